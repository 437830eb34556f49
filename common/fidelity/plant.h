#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/fidelity/random.h"
#include "common/fidelity/tracks.h"
#include "common/math/sym3.h"
#include "common/math/vec.h"

// A simulated haptic device and the hand on it, to judge force laws. SI units.
//
// Tip: point mass with viscous damping b and Coulomb friction c per axis, optionally split by one
// structural mode (motor mass, spring, tip mass; the encoder sits on the motor side). Encoder:
// cells of edge delta on the lattice below, read as cell middles. Motors: hold their force between
// ticks, saturate, answer after whole ticks of delay; ticks can be late (jitter) or lost (the force
// is held on).
//
// Integration: sub-stepped by the implicit midpoint rule: half a step of implicit Euler, linearly implicit in b, the
// hand's stiffness and the hand's damping, carried on to the whole step. Second order, and it neither adds energy to
// a spring nor takes any (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2006, IV.2), so that what a loop
// gives back is not lost in the simulation. Friction is the impulse that can at most stop an axis, first order where
// an axis stops. IntegrationError in trial.h reports the error against a finer step.
//
// Signs and frames: common/haptics/README.md, "Conventions", has the drawing.
namespace enamel::fidelity {

// Position of the encoder's cells. Default: cells of edge delta along x, y and z, no noise. Joint
// counts: row i of `joints` is the direction in which encoder i counts, q = joints * tip, in cells
// of edge delta. A rotation keeps the cells cubes; unit rows that are not orthogonal shear them.
// The reading is the joint cell's middle, converted back to x, y and z. Validity: an invertible
// matrix (checked by Plant); one matrix over a whole trial, as a real arm has over a few
// millimetres.
struct Lattice {
  glm::dmat3 joints{1};
  // Edge to which a driver rounds the position again, per axis; 0: no rounding.
  double driver_cell_m = 0;
  // Each joint's count is off by a whole number uniform in -n..n, drawn each tick from separate
  // random numbers: trials with and without noise have the same jitter and lost ticks.
  int noise_counts = 0;
};

struct PlantSpec {
  double mass_kg = 0.1;          // of the device at its tip
  double damping_n_s_per_m = 0;  // b
  double friction_n = 0;         // c, per axis
  double resolution_m = 10e-6;   // delta
  Lattice lattice;               // of the encoder's cells
  double tick_s = 1e-3;          // T
  double peak_force_n = 1e9;     // motors saturate per axis here
  int delay_ticks = 0;           // from reading to force, whole ticks
  // Structural mode: 0 for a rigid device. The tip carries mode_tip_share of the mass.
  double mode_hz = 0;
  double mode_damping_ratio = 0.02;
  double mode_tip_share = 0.3;
  double jitter_ratio = 0;  // tick lasts T (1 + jitter u), u uniform in [-1, 1]
  double drop_ratio = 0;    // share of ticks that never happen
  uint64_t seed = 1;
  int substeps = 8;
};

// The hand's action during one sub-step: a force, and a spring and damper to a moving equilibrium,
// which the integrator treats implicitly.
struct Grip {
  dvec3 force_n{0};
  dvec3 equilibrium_m{0}, equilibrium_speed_m_per_s{0};
  double stiffness_n_per_m = 0, damping_n_s_per_m = 0;
  bool prescribed = false;  // the tip is at the equilibrium, whatever the force
};

// An operator. `t_s` runs from the start of the trial.
class Hand {
 public:
  virtual ~Hand() = default;
  virtual double mass_kg() const { return 0; }  // moves with the tip
  virtual Grip At(double t_s) = 0;
};

// Between motors and hand: what the device itself adds to the resisting force. Means over the last tick; each
// resists the motion. A device that rests takes up to c of the motors' force with its friction, and the hand
// the rest; of a prescribed tip that rests nobody can say which.
struct DeviceForces {
  dvec3 friction_n{0};
  dvec3 damping_n{0};
  dvec3 inertia_n{0};  // of the device's mass; the hand's own is the hand's
};

// Thread safety: none; one per trial.
class Plant {
 public:
  // `hand` is borrowed and outlives the plant.
  Plant(const PlantSpec& spec, Hand& hand, const dvec3& start_m);

  // The driver's reading: the middle of the encoder cell of the motor side, with noise and the
  // driver's own rounding. The same however often it is read within a tick.
  dvec3 Read() const;
  // Whether this tick is lost: the controller is not run and the last force is held.
  bool TickLost();
  // Holds the command (delayed, saturated) for one tick.
  void Step(const dvec3& command_n);
  // The same when the controller did not run.
  void StepHeld();
  // One tick with an ideal damper in place of the motors' force: R = b v of the tip (N s/m), within
  // `peak_n`, solved with the motion. Returns the mean R of the tick. For a rigid device.
  dvec3 StepDamped(const Sym3& b, double peak_n);

  double time_s() const { return time_s_; }
  const dvec3& tip_m() const { return tip_; }
  const dvec3& motor_m() const { return motor_; }
  const dvec3& speed_m_per_s() const { return tip_speed_; }
  const dvec3& sent_n() const { return sent_; }
  const DeviceForces& device_forces() const { return device_; }
  // The force in the hand: the motors' resistance (of StepDamped, the damper's) and the device's own forces.
  // Mean over the last tick.
  dvec3 in_hand_n() const {
    return resisted_ + device_.friction_n + device_.damping_n + device_.inertia_n;
  }
  double last_tick_s() const { return last_tick_s_; }

 private:
  void Advance();
  void DrawNoise();
  // The tip's next speed from the impulse it gets: friction, and b beside the device's own damping.
  struct Push {
    dvec3 impulse;       // N s, with friction taken off
    dvec3 friction_n;    // that was
    double lead_kg = 0;  // mass and what is implicit
  };
  Push PushOf(const Grip& grip, double dt) const;
  // Adds a sub-step to the tick's means.
  void Account(const dvec3& friction_n, const dvec3& damping_n, const dvec3& inertia_n);
  // The friction of a prescribed tip.
  dvec3 PrescribedFriction(const dvec3& speed, const dvec3& resisted_n) const;
  // Sub-step number i of the tick: half of it by `step(grip, step_s)`, one of the following.
  template <typename Euler>
  void Substep(int i, double dt, Euler&& step);
  // Implicit Euler.
  void RigidStep(const Grip& grip, double dt);
  dvec3 DampedStep(const Grip& grip, const Sym3& b, double peak_n, double dt);
  void FlexibleStep(const Grip& grip, double dt);

  PlantSpec spec_;
  Hand& hand_;
  double hand_mass_;
  Random random_, noise_random_;
  glm::dmat3 from_joints_{1};
  bool joint_cells_ = false;
  dvec3 noise_counts_{0};
  dvec3 tip_, tip_speed_{0}, motor_, motor_speed_{0}, sent_{0}, resisted_{0};
  DeviceForces device_;
  std::vector<dvec3> pipe_;
  size_t pipe_at_ = 0;
  double time_s_ = 0, last_tick_s_ = 0;
};

}  // namespace enamel::fidelity
