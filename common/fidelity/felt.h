#pragma once

#include <optional>
#include <vector>

#include "common/fidelity/board_loop.h"
#include "common/fidelity/plant.h"
#include "common/haptics/coupling.h"
#include "common/haptics/guard.h"
#include "common/math/sym3.h"

// How well a force law passes for an ideal damper in a hand.
//
// Three simulations of one hand:
// * the device with the law behind encoder and delay: the force sent, and the force in the hand, to which the
//   device's friction, damping and inertia add (plant.h);
// * the same device with an ideal damper R = B v in place of the motors' force. Against it the command is
//   judged: a reference B times the recorded speed would charge the law with what friction and a soft hand do
//   to any force;
// * an ideal tool: the damper alone, without mass, damping, friction or ceiling. Against it the force in the
//   hand is judged: all that keeps the device from being the tissue is error. FeltBudget (budget.h) says
//   what each part of the device takes.
//
// Deterministic. SI units. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::fidelity {

// What carries the law: numbers of a device profile.
struct FeltDevice {
  double mass_kg = 0, damping_n_s_per_m = 0, friction_n = 0;
  double resolution_m = 0, kc_n_per_m = 0, peak_force_n = 0;
  double tick_s = 1e-3;  // of the law; the spring's too, unless it is on the board
  BoardSpec board{};
  // Of the loop that reads the encoders and drives the motors.
  double inner_tick_s() const { return board.ticks > 0 ? tick_s / board.ticks : tick_s; }
};

// What holds it.
struct HandOn {
  // Stiffness of the grip. 0: the hand pushes, and `push_n` is its force. None: it prescribes the way.
  std::optional<double> stiffness_n_per_m;
  double mass_kg = 0.1;  // moves with the tip
  // Of the grip; without a value 0.6 of critical damping of hand and device, 1.2 sqrt(k m).
  std::optional<double> damping_n_s_per_m;
  dvec3 push_n{0};
};

struct FeltTrial {
  haptics::LawKind law = haptics::kDefaultLaw;
  haptics::EstimatorParams estimator{};  // for laws that need a speed
  Sym3 b_n_s_per_m = Sym3::Isotropic(6500);
  // Tissue that is cut by load, in b's place and alike in every direction. Requires: neither ideal nor tool.
  std::optional<FeedForce> load = {};
  HandOn hand;
  Lattice lattice;
  int delay_ticks = 0;  // of the law's loop, where the host runs the spring
  // The device's friction that the law assumes. It may be wrong.
  haptics::OwnFriction friction{};
  double from_s = 0;  // figures are taken from here on
  // Without the damper on the device the error of the command and the ideal stay 0; without the ideal tool
  // the figures of the force in the hand do.
  bool ideal = true, tool = true;
};

struct FeltSecond {
  double tool_rms_n = 0, error_rms_n = 0;
};

struct FeltFigures {
  double ideal_rms_n = 0, error_rms_n = 0;  // of the command
  // Of the force in the hand: RMS of the tool's, RMS of the error, and what 95 % of the errors are within.
  double tool_rms_n = 0, felt_error_rms_n = 0, felt_error_p95_n = 0;
  // For each whole second: RMS of the tool's force, and of the error.
  std::vector<FeltSecond> seconds;
  double ripple_n = 0;             // RMS of the force above 15 Hz (second order)
  dvec3 mean_n{0};                 // R
  double least_n = 0, most_n = 0;  // of R along `mean_n`
  double energy_min_j =
      0;  // of the theorem's balance, above its floor; never below 0 where it holds
  // As shares of the right force: of the command, and of the force in the hand.
  double command_error() const { return ideal_rms_n > 0 ? error_rms_n / ideal_rms_n : 0; }
  double felt_error() const { return tool_rms_n > 0 ? felt_error_rms_n / tool_rms_n : 0; }
};

// The equilibrium of the grip follows `way_m` (way.h). Requires: positive numbers of the device, a way of
// at least 10 steps.
FeltFigures Feel(const FeltDevice& device, const FeltTrial& trial, const std::vector<dvec3>& way_m);

// The force in the hand in each tick of the device's loop, R, from the start; `damper`: with an ideal damper
// in the motors' place, within their ceiling. Requires as `Feel`.
std::vector<dvec3> ForceInHand(const FeltDevice& device, const FeltTrial& trial,
                               const std::vector<dvec3>& way_m, bool damper);
// The hand with the damping that it has on a device of this mass, so that it is the same on another.
HandOn SameHand(HandOn hand, double device_kg);
// The device that adds nothing: no mass, damping, friction or ceiling.
FeltDevice ToolOf(const FeltDevice& device);

// The cell that the guard is told for this lattice (haptics/guard.h).
haptics::TipCell CellOf(const Lattice& lattice, double resolution_m);

// Closed form of the felt error of a Maxwell coupling of stiffness `k` in a grip `kh`, small motion of
// frequency `omega`, without friction and cells: |H/H_ideal - 1| of the two grips' dampers,
// H = kt s/(s + kt/B), kt = kh k/(kh + k), against kh s/(s + kh/B). SI units.
double ClosedFormError(double hand_n_per_m, double k_n_per_m, double b_n_s_per_m,
                       double omega_rad_per_s);

}  // namespace enamel::fidelity
