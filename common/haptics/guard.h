#pragma once

#include <cmath>

#include "common/base/check.h"
#include "common/math/vec.h"

// The guard: how far the rest point of the coupling's spring may move in one step so that the
// operator can never draw more energy than is there. With a tank, what the operator has already
// lost may pay for a step that raises the spring's energy. The proof is in README.md, "Why it is
// passive"; its symbols: x true tip, p measured tip, r rest point, e = p - r, R = Kc e, V = Kc/2
// |x - r|^2, E energy in the tank, T tick, b and c the device's own damping and Coulomb friction,
// d whole ticks from reading to force.
//
// Claim: V + E never rises in a guarded step, wherever in its cell the tip is, so with
// Kc <= 2 b / ((d + 1)^2 T) and c >= TipCell::Friction the sum of R.dx + (b/T) |dx|^2 + sum c_i
// |dx_i| never falls under -(V_0 + E_0), whatever the hand, the tissue and the law do.
//
// All functions: world frame, SI units, any thread (no state but the Tank given), real-time safe,
// only + - * / sqrt. What is not finite moves nothing and leaves the tank alone.
namespace enamel::haptics {

// Where the true tip can be around the measured one: the sum of a box along the axes of space, a
// ball and a parallelepiped, all centred on p. Whatever noise or lattice a device has, the proof
// needs only |u.(x - p)| <= Support(u) at every tick, so a cell may turn and stretch with the pose.
struct TipCell {
  dvec3 half_m{0};    // half cell per axis (the driver's rounding); n counts of noise add n delta
  double ball_m = 0;  // radius of a ball that holds any joint lattice's cell; 0: Cartesian device
  // Columns J_j dq_j/2: half edges of the cell of joint encoders at this pose. Zero: unused.
  dmat3 joint_half_m{0.0};
  double Support(const dvec3& w) const noexcept {
    double s = half_m.x * std::fabs(w.x) + half_m.y * std::fabs(w.y) + half_m.z * std::fabs(w.z);
    if (ball_m > 0) s += ball_m * std::sqrt(Dot(w, w));
    return s + std::fabs(Dot(joint_half_m[0], w)) + std::fabs(Dot(joint_half_m[1], w)) +
           std::fabs(Dot(joint_half_m[2], w));
  }
  // Largest |x - p|, m.
  double Radius() const noexcept;
  // Least Coulomb friction per axis of space, N, that pays for what the cell hides. A device whose
  // friction acts along other (orthonormal) axes, such as joints, needs Kc Radius() on each.
  dvec3 Friction(double kc_n_per_m) const noexcept;
};

// Cell of an encoder of resolution delta along the axes of space, with noise of `counts` counts.
TipCell CartesianCell(const dvec3& resolution_m, double counts = 0) noexcept;
// Cell of a cubic lattice of edge delta turned any way, with a driver that rounds the result again
// to `rounding_m` (0: it does not) and noise of `counts` joint counts.
TipCell LatticeCell(double resolution_m, double rounding_m, double counts = 0) noexcept;

// Energy that may pay for raising the spring's. E_0, what it starts with, is part of the floor:
// declare it, grant it once per attempt, never again on a reset.
struct Tank {
  double energy_j = 0;
  double cap_j = 0;            // nothing flows in above it
  double inflow_share = 0.05;  // of the operator's work in a tick
  // Of this tick: what has flown in, J, and how far the rest point has moved, m. Cleared by
  // BeginTick, which must be called once before the first step of every tick: with delay the proof
  // needs it, without delay a tank that is not told only fills less.
  double admitted_j = 0;
  dvec3 moved_m{0};

  void BeginTick() noexcept {
    admitted_j = 0;
    moved_m = dvec3(0);
  }
};

struct GuardParams {
  double kc_n_per_m = 0;  // of the spring as it is felt: Kc times StiffnessShare
  TipCell cell{};
  int delay_ticks = 0;  // upper end of what was measured; a delay that varies below it is covered
  // With delay: how much of a move's square, beside V's own half, is kept for the forces under way,
  // as halves (above 0). 1 lets the rest point reach the tip in one step and needs Kc <= 2 b / ((d
  // + 1)^2 T); more shortens steps to 2/(1 + weight) and needs only Kc <= 2 b / ((1 + 2 d +
  // d^2/weight) T).
  double delay_weight = 1;
};

// Largest s in [0, 1] such that moving the rest point by s w cannot raise V + E (with delay: nor
// what the forces still under way may give back); updates the tank. The caller moves the rest point
// by s w. work_j: the operator's measured work R.dx since the last tick, the same for every step of
// a tick; together they let in at most its share. It bounds the inflow only, so an error in it is
// harmless: what flows in never exceeds the drop of V that is certain.
ENAMEL_REALTIME double GuardedStep(const GuardParams& params, const dvec3& e_m, const dvec3& w_m,
                                   double work_j, Tank& tank) noexcept;

// Share k in [0, 1] of the stiffness with which the spring may be felt, so that the sent force k Kc
// e stays within bound_n: for what is left of a bound after the rest point has given way as far as
// the guard lets it (a bound under Kc Radius()). A share falls freely and rises as far as the
// tank pays; at 0 with an empty tank it stays there until a reset. share_before: last tick's, 1
// after a reset. The proof covers it without delay; with delay a fall gives back at most Kc |e| per
// metre of the next d ticks.
ENAMEL_REALTIME double StiffnessShare(const GuardParams& params, const dvec3& e_m, double bound_n,
                                      double share_before, Tank& tank) noexcept;

// After ticks in which no force was sent: share s in [0, 1] of the stretch with which the spring
// may continue, rest point at p - s e, so that it costs no more than a reset (which starts a new
// count with V_0 <= Kc/2 Radius()^2). It is a reset and a guarded step back that the tank pays.
// kept_j pays first: what surely was in the spring when the force stopped. It is 0 when the tip
// moved unseen, as between the last reading and the stop: it may have taken all. With delay: only
// once the forces under way have ended, after BeginTick and in the same tick as the steps that
// follow.
ENAMEL_REALTIME double ResumedShare(const GuardParams& params, const dvec3& e_m, double kept_j,
                                    Tank& tank) noexcept;

}  // namespace enamel::haptics
