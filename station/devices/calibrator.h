#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/devices/device.h"

// Measures the properties of a haptic device that a force law needs: cell, noise, Coulomb friction,
// viscous damping, effective mass and bus delay, per axis. It moves the device with its own motors;
// nobody may hold it.
//
// Rest (2 s, no force): noise is the standard deviation about a straight line through the counts,
// less the cell's own delta^2/12 (Sheppard).
//
// Pushes (per axis): switches a force on and fits the motion of a damped mass to the motion that
// follows. The fitted start t0 gives the bus delay. Where a rigid mass does not explain the motion,
// the model has a structural mode: its motor's side runs ahead at first, which a rigid fit mistakes
// for up to 1.5 ticks less of delay. The intervals of delay and mode are from leaving out a push at a
// time.
//
// Swings (per axis): sinusoidal targets at four speeds, held by a weak spring and damper. In the
// periodic motion that follows, the fundamentals obey exactly
//
//   F = (-m w^2 + j b w) X + c S,
//
// X, F and S the complex amplitudes of position, force (as it arrives: half a tick and the bus
// delay after it was sent) and sign of velocity. While the device sticks, friction balances the
// force, and neither counts. Two real equations per period; m, b and c by least squares over all of
// them. Intervals: from the residuals, from leaving out a speed at a time, and the model's possible
// error (1 %; friction 4 %; mass by the damping times 0.4 ms of phase). Constant terms (gravity,
// friction that is stronger one way) have no fundamental.
//
// Cell: the steps between neighbouring values of all counts ever seen. A device that reports finer
// than it measures shows steps of more than one count. An arm that counts joints moves along x, y
// and z at once, by amounts that vary with its pose, in steps of any size. There the cell is the
// length of a move of one joint's count (alone in time, or by the block of places that noise shows
// at rest), less the part that a driver's rounding adds; one figure for all axes. Along an axis a
// position may then be off by up to sqrt(3)/2 of it.
namespace enamel::station {

struct CalibratorSetup {
  std::array<double, 3> count_m{};  // way per count, of the device's report
  double tick_s = 1e-3;
  double max_force_n = 2;  // never more than this, per axis
  double reach_m = 0.008;  // swings go so far each way; twice as far is an error
};

struct Estimate {
  double value = 0;
  double uncertainty = 0;  // half the 95 % interval
  int64_t samples = 0;
};

// One axis. SI units; delay in ticks, with its fraction.
struct AxisFigures {
  Estimate resolution_m, noise_m, friction_n, damping_n_s_per_m, mass_kg, delay_ticks;
  Estimate mode_hz;  // first structural mode; 0 without samples: a rigid device explains the pushes
  double count_m = 0;   // way per reported count
  bool joints = false;  // the cell is that of encoders at the joints
};

// Passive limit of Kc with this delay and its fraction: 2 b / ((d + 1)^2 T), as
// haptics::CouplingStiffness for whole ticks. d is the upper end of the measured interval: omitting
// half a tick would make Kc more than twice too stiff. A profile, which has whole ticks, takes
// WholeTicks and the smaller of the two limits.
double PassiveStiffness(double damping_n_s_per_m, double tick_s, const Estimate& delay) noexcept;

// The whole ticks that cover the delay and its interval, for profile and guard. Up to a quarter of
// a tick, which the interval alone may reach, is not rounded up: PassiveStiffness pays for it.
int64_t WholeTicks(const Estimate& delay) noexcept;

// Call Step once per tick with the device's sample, and send the force it returns. No clock, no
// thread: a simulated device runs as fast as the machine. Thread safety: none. Real-time: Step
// allocates nothing after construction.
class Calibrator {
 public:
  explicit Calibrator(const CalibratorSetup& setup);

  // Force to send before the next tick, N, per device axis. Zero when done or failed.
  dvec3 Step(const DeviceSample& sample) noexcept;
  bool done() const noexcept { return phase_ == Phase::kDone || failed(); }
  bool failed() const noexcept { return phase_ == Phase::kFailed; }
  double progress() const noexcept;  // 0..1
  // The current activity, as a sentence for the person watching.
  std::string Doing() const;
  // Requires: done(). Errors: kUnavailable, with the failure and the remedy: silent or unplugged,
  // does not move, ran away.
  Result<std::array<AxisFigures, 3>> Figures() const;

 private:
  enum class Phase : uint8_t { kRest, kPulses, kSwings, kDone, kFailed };
  struct Swing {
    double hz, amplitude_m;
    int periods;
  };
  struct Push {
    size_t begin, ticks;
  };
  static constexpr size_t kSwingCount = 4;
  static const std::array<Swing, kSwingCount> kSwings;
  static constexpr int kPulses = 8;

  void Fail(const char* why) noexcept;
  bool Watch(const DeviceSample& sample) noexcept;
  dvec3 Rest() noexcept;
  double Pulse() noexcept;
  double SwingForce() noexcept;
  double Hold(double target_m, double target_m_per_s) noexcept;
  double Velocity() const noexcept;
  void NextAxis() noexcept;
  int64_t TicksOf(const Swing& swing) const noexcept;
  int64_t SettleTicks() const noexcept;

  double Delay(size_t axis, double cell_m, double noise_m, double g, AxisFigures& out) const;
  double PushResidual(size_t axis, const Push& push, double t0_ticks, double g, double w) const;
  double NearestMode(size_t axis, const std::vector<Push>& pushes, size_t without, double g,
                     double t0_ticks, double w) const;
  double Beginning(size_t axis, const std::vector<Push>& pushes, size_t without, double g,
                   double variance_m2, double& w) const;
  Estimate StepOf(size_t axis) const;
  Estimate JointCell() const;
  Estimate RestingCell(double rounded_m) const;
  Estimate Cell(size_t axis) const;
  Estimate Noise(size_t axis, double cell_m) const;
  double Range(size_t axis, size_t i, int64_t ticks, double& way_m) const;
  bool Dynamics(size_t axis, double delay_ticks, double cell_m, AxisFigures& out) const;

  const CalibratorSetup setup_;
  Phase phase_ = Phase::kRest;
  const char* why_ = "";
  size_t axis_ = 0, swing_ = 0;
  int64_t tick_ = 0, phase_tick_ = 0, total_ticks_ = 0;
  std::array<double, 3> home_m_{};
  double push_from_m_ = 0;
  int64_t push_ticks_ = 0;  // 0: still pushing
  int silent_ = 0;

  // All counts seen and forces sent, (ticks x 3), and where each part begins.
  std::vector<std::array<int32_t, 3>> counts_;
  std::vector<std::array<float, 3>> forces_;
  std::array<int64_t, 3> pulses_begin_{}, swings_begin_{};
  int64_t rest_ticks_ = 0, pulse_ticks_ = 0, push_limit_ = 0;
};

}  // namespace enamel::station
