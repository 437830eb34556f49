#pragma once

#include <array>
#include <atomic>
#include <memory>

#include "common/fidelity/random.h"
#include "station/devices/device.h"
#include "station/devices/operator.h"

namespace enamel::station {

// Parameters of a simulated device. SI units.
struct PlantParams {
  double mass_kg = 0;            // apparent mass of the device
  double hand_mass_kg = 0.1;     // of the hand, lumped to it
  double damping_n_s_per_m = 0;  // b
  double friction_n = 0;         // c, Coulomb, per axis
  double resolution_m = 0;       // delta: edge of an encoder cell
  dmat3 joints{1};               // rows: directions in which the encoders count; orthonormal
  double count_m = 0;            // edge of a reported count, to which a driver rounds; 0: delta
  double peak_force_n = 0;       // the motors saturate here
  // Rotation, for a device that drives six axes: device and hand are lumped, and the hand holds its
  // orientation by a spring and a damper. Inertia 0: the device does not drive rotation, and its
  // gimbal goes with the hand.
  double inertia_kg_m2 = 0;
  double rotational_damping_n_m_s = 0;  // b_rot
  double rotational_friction_n_m = 0;   // c_rot, Coulomb, per axis
  double orientation_cell_rad = 0;      // largest error of the recorded orientation
  double peak_torque_n_m = 0;
  double hand_n_m_per_rad = 1, hand_n_m_s = 0.01;
  double tick_s = 0.001;
  dvec3 origin_m{0};    // scene position of counts (0, 0, 0)
  int substeps = 16;    // per tick
  int delay_ticks = 0;  // of the bus: a force acts so many ticks later, at most kMaxDelay
  double noise_m = 0;   // of the sensor, standard deviation per axis, before the encoder rounds
  uint64_t seed = 1;    // of the noise
};

// A rigid mass with damping, Coulomb friction, an encoder and motors that hold their force for a
// tick, in the hand of a simulated operator. Each ReadSample advances its time by one tick. It does
// not use the real time, so a lockstep run gives exactly the same as a slow one.
//
// Integration: half a step of motion, the step's impulse, half a step of motion (leapfrog, second
// order, no drift of energy), `substeps` per tick; friction is the impulse that can at most stop
// the mass. The motor force is constant within a tick, so a step need only resolve the hand's own
// oscillation (1 N/mm on 45 g: 24 Hz). 16 steps agree with 1024 to a tenth of a count: 1 um
// (simulated_device_test).
class SimulatedDevice final : public Device {
 public:
  static constexpr int kMaxDelay = 15;
  // `op` must not be null.
  SimulatedDevice(const PlantParams& params, std::unique_ptr<SimulatedOperator> op);

  std::string Name() const override;
  Hand hand() const override;
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  ENAMEL_REALTIME void SendForce(const dvec3& force_n) noexcept override {
    SendForceAndTorque(force_n, dvec3(0));
  }
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override;
  ENAMEL_REALTIME void ShowBur(const dvec3& tip_m) noexcept override { bur_m_ = tip_m; }

  // The true tip, which no real device reports.
  const dvec3& position_m() const noexcept { return x_; }
  const dvec3& velocity_m_per_s() const noexcept { return v_; }
  const Quat& orientation() const noexcept { return turned_; }
  // Share of the operator's plan done, 0..1. From any thread.
  double progress() const noexcept { return progress_.load(std::memory_order_relaxed); }

 private:
  void Substep(const HandDrive& hand, const dvec3& equilibrium_m, double dt) noexcept;
  void Turn(const HandDrive& hand, double dt) noexcept;
  Quat Read(const Quat& orientation) const noexcept;

  const PlantParams params_;
  const double count_m_;
  std::unique_ptr<SimulatedOperator> operator_;
  std::atomic<double> progress_{0};
  double Noise() noexcept;
  dvec3 ReadTip() noexcept;

  dvec3 x_{0}, v_{0}, sent_n_{0}, motor_n_{0}, bur_m_{0};
  Quat turned_;
  dvec3 spin_{0}, sent_n_m_{0}, motor_n_m_{0};
  std::array<dvec3, kMaxDelay + 1> pipe_{}, torques_{};  // rings of forces and torques in transit
  size_t pipe_at_ = 0;
  fidelity::Random random_;
};

}  // namespace enamel::station
