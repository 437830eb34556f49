#pragma once

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/board/guard.h"
#include "common/math/vec.h"

// Takes the device's own Coulomb friction out of the force in the hand, as far as that is passive
// (README.md, "What the wish leaves out" and "What the spare friction pays for").
//
// SI units. Thread safety: none, one loop owns it. Real-time: all but VisitState are safe (no allocation).
// Deterministic: + - * / sqrt.
namespace enamel::haptics {

// B/Kc of the tissue in which half of c is left out, less in harder tissue. In hard tissue a soft spring lacks
// force, and friction hides a part of that.
// Guessed, chosen: with a true c of half or twice the guess, 1 of 4 608 strokes is felt worse by more than a
// point than with nothing left out. Four times as long makes more of them worse, a tenth gains little.
// Measured, chosen: at 1 s no shipped device loses more than 0.2 points in the strokes of the exercises against
// none, and the soft ones gain up to 1.7.
inline constexpr double kGuessedHalf_s = 0.040, kMeasuredHalf_s = 1;
// Where B/Kc is smaller the relief softens the spring until B/K is this. The spring then lags by no more, and
// the motors may push with the friction that its cell does not need. Chosen: the felt error in the strokes of the exercises
// is flat from 0.04 to 0.06 s (README.md).
inline constexpr double kSoftest_s = 0.050;

// Friction and motors both resist the hand, so the force asked of the motors is less by the friction.
struct OwnFriction {
  dvec3 c_n{0};  // per axis; 0: nothing is left out
  // c is the lower end of a measurement on this unit, over its axes and postures: pushing with more than there is would
  // drive the hand. Else c is a guess, and the motors never push.
  bool measured = false;
  // The constants above; tests/station/lab/laws/friction_test.cpp notices other values. With half_s 0 the law leaves
  // nothing out.
  double half_s = measured ? kMeasuredHalf_s : kGuessedHalf_s, softest_s = kSoftest_s;
};

// Chosen: ten ticks, in which no hand reverses, and noise of single readings does not make the motors rattle.
inline constexpr double kRelief_s = 0.010;
inline constexpr double kMinSoftness = 1.0 / 16;

// The force asked of the motors for a pull R in tissue of damping b along R. Per axis
// S_i = sgn(R_i) max(0, |R_i| - phi c_i), phi = tau/(tau + b/Kc), tau = half_s. S is continuous in R: where R changes sign, S is 0
// over a width of 2 phi c_i and cannot chatter. It reads no speed.
dvec3 LessFriction(const dvec3& pull_n, double b_n_s_per_m, double kc_n_per_m,
                   const OwnFriction& own) noexcept;

class FrictionRelief {
 public:
  // `radius_m` of the tip's cell; `soften`: the spring may be made softer. Requires: no delay then.
  FrictionRelief(const OwnFriction& own, double kc_n_per_m, double tick_s, double radius_m,
                 bool soften) noexcept;

  // No force is under way: an attempt begins.
  void Reset() noexcept;
  // The tip has moved unseen: where it goes is not known.
  void Forget() noexcept { push_n_ = dvec3(0); }

  // The force along the motion, on the operator, where friction resists more than the tissue. Its length is at most the
  // least friction of the three axes, less the part that pays for the cell of a spring of this stiffness.
  ENAMEL_REALTIME dvec3 Push(const dvec3& pull_n, double b_n_s_per_m, double kc_n_per_m) noexcept;

  // Where the share of the stiffness should go in this tick, in tissue of this damping.
  ENAMEL_REALTIME double NextShare(double b_n_s_per_m) const noexcept;
  // Takes the share there. A fall is free; a rise costs the tank what it may add to a spring of stiffness Kc that is
  // stretched by `stretch_m`, as measured, and ends where the tank is empty.
  ENAMEL_REALTIME void TakeShare(double next, double stretch_m, EnTank* tank) noexcept;
  double share() const noexcept { return share_; }

  void VisitState(StateArchive& archive) { archive(push_n_, share_); }

 private:
  OwnFriction own_;
  double kc_, tick_s_, radius_m_;
  bool soften_;
  dvec3 push_n_{0};
  double share_ = 1;
};

}  // namespace enamel::haptics
