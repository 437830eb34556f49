#include <cmath>

#include "common/haptics/force_law.h"
#include "common/haptics/wall.h"
#include "common/math/order.h"

namespace enamel::haptics {
namespace {

// Times are in units of sqrt(kHeaviest / Kc): how long the heaviest hand takes to answer the spring.
// Origin of all: the search described in README.md, "How the constants were found"; each has a test in
// tests/common/haptics/lead_maxwell_test.cpp that notices it.
constexpr double kHeaviest_kg =
    0.6;                            // hand (0.5 kg) and device: heavier ones are not damped in time
constexpr double kShock = 0.8;      // time of the shock absorber
constexpr double kLead = 20;        // time in which the spring becomes stiffer, ...
constexpr double kLeadOfTau = 0.3;  // ... at most this share of B/Kc: soft tissue is quicker
constexpr double kGain = 6;         // n = sqrt(B / (kGain sqrt(kHeaviest Kc)))
constexpr double kMaxGain = 3.8;    // n is at most this
constexpr double kShare = 0.5;      // part of the spring that absorbs shocks, from n = 2 on
// Of the bur's distance to the slow tip, in cells: below it shocks are not absorbed, n is 1. A force of
// a few counts is the encoder's, and leading it would only amplify the grain.
constexpr double kShockFrom_cells = 3, kLeadFrom_cells = 10;
// Share of B that counts as none, in B (B + share tr B I)^-1: what is left of a way where B resists.
constexpr double kFree = 1e-9;

double UnitOf(double kc) noexcept { return kc > 0 ? std::sqrt(kHeaviest_kg / kc) : 0; }

// n of tissue that resists with b; `from` is kGain sqrt(kHeaviest Kc), the b where it begins.
double GainIn(double b, double from) noexcept {
  if (!(b > from)) return 1;
  const double wall = b / kWall_n_s_per_m;
  const double gain = LowerOf(std::sqrt(b / from), kMaxGain);
  return 1 + (gain - 1) / (1 + wall * wall);
}

// Lead Maxwell: R = (1-alpha) Kc (p - f) + alpha Kc (p - x) + n Kc (x - a), and the bur a goes as R/B.
//
// x follows the tip slowly, f quickly. Fast motion meets Kc, which is all that the device can hold stably.
// Slow motion meets n Kc (x = p), so that a hand feels a damper and not the spring before it. A spring
// that stiffens late feeds a hand that swings; what absorbs shocks, (1-alpha) Kc in series with a damper,
// takes that energy out again. n, alpha: above.
//  * On the way back R falls at least in proportion to the tip's distance from the bur (FallBack), so
//    that it is 0 where the tip meets the bur: a hand that lifts is not pushed on past it.
//  * The pull is toward the tip and not past it: s = R/(n Kc) stays in the ball with diameter a..p.
//  * In directions in which B does not resist, x = f = p.
// None of that is in the proof: it says where the rest point should be, and the guard how far it goes.
class LeadMaxwell final : public ForceLaw {
 public:
  explicit LeadMaxwell(const LawParams& params)
      : kc_(params.kc_n_per_m), tick_s_(params.tick_s), play_m_(params.play_m) {
    // The edge of a cube that the play is the diagonal of.
    cell_m_ = play_m_ / std::sqrt(3.0);
    unit_s_ = UnitOf(kc_);
    gain_from_ = kGain * kc_ * unit_s_;
    Reset(dvec3(0));
  }

  bool anchored() const noexcept override { return true; }
  void Reset(const dvec3& tip_m) noexcept override {
    tip_ = tip_m;
    PassAir();
  }
  void PassAir() noexcept override { fresh_ = true; }
  void BeginTick(const dvec3& tip_m) noexcept override {
    tip_ = tip_m;
    seen_ = false;
  }

  Pull PullOn(const dvec3& anchor, const Sym3& b) noexcept override {
    if (fresh_) {
      slow_ = quick_ = anchor;
      settled_ = tip_;
      sought_ = dvec3(0);
      fresh_ = false;
    }
    const Spring spring = SpringIn(anchor, b);
    slow_ = tip_ + Resisted(b, slow_ - tip_);
    quick_ = tip_ + Resisted(b, quick_ - tip_);
    dvec3 stretch;
    if (seen_) {
      stretch = Stretch(anchor, spring);
    } else {
      seen_ = true;
      stretch = Follow(anchor, spring);
    }
    StopAtTip(anchor, stretch);
    // As it would be with the tip where it settled: noise of the reading is no way back.
    sought_ = stretch * spring.gain - (tip_ - settled_);
    return {stretch, spring.gain * kc_};
  }

  void VisitState(StateArchive& archive) override {
    archive(tip_, slow_, quick_, settled_, sought_, seen_, fresh_);
  }

 private:
  struct Spring {
    double damping_n_s_per_m = 0;  // B toward the tip
    double gain = 1, shock = 0;    // n, 1 - alpha
  };

  Spring SpringIn(const dvec3& anchor, const Sym3& b) const noexcept {
    // Only of the way that is resisted: a hand may move fast in a direction that is free.
    const dvec3 e = Resisted(b, tip_ - anchor), z = slow_ - anchor;
    const double e2 = Dot(e, e), z2 = Dot(z, z);
    Spring out;
    out.damping_n_s_per_m = e2 > 0 ? Dot(e, b * e) / e2 : b.Trace() / 3;
    if (!(out.damping_n_s_per_m > gain_from_)) return out;
    const double gain = GainIn(out.damping_n_s_per_m, gain_from_);
    out.shock = kShare * LowerOf(gain - 1, 1) * Beyond(z2, kShockFrom_cells);
    out.gain = 1 + (gain - 1) * Beyond(z2, kLeadFrom_cells);
    return out;
  }

  // Rises from 0 to 1 where a distance comes to `cells`.
  double Beyond(double distance2, double cells) const noexcept {
    const double from = cells * cell_m_, from2 = from * from;
    return distance2 > 0 ? distance2 / (distance2 + from2) : 0;
  }

  // The part of a way in directions in which b resists.
  static dvec3 Resisted(const Sym3& b, const dvec3& way) noexcept {
    return b * SolveShifted(b, kFree * b.Trace(), way);
  }

  dvec3 Stretch(const dvec3& anchor, const Spring& s) const noexcept {
    return slow_ - anchor + ((tip_ - quick_) * s.shock + (tip_ - slow_) * (1 - s.shock)) / s.gain;
  }

  // Once a tick: slow and quick tip follow, and on the way back R falls.
  dvec3 Follow(const dvec3& anchor, const Spring& spring) noexcept {
    const dvec3 before = settled_;
    const dvec3 off = tip_ - settled_;
    const double distance = std::sqrt(Dot(off, off));
    if (distance > play_m_) settled_ = tip_ - off * (play_m_ / distance);
    const double tau = spring.damping_n_s_per_m / kc_;
    const double lead_s = LowerOf(kLead * unit_s_, kLeadOfTau * tau);
    const double shock_s = LowerOf(kShock * unit_s_, tau);
    quick_ += (tip_ - quick_) * (tick_s_ / (shock_s + tick_s_));
    slow_ += (tip_ - slow_) * (tick_s_ / (lead_s + tick_s_));
    dvec3 stretch = Stretch(anchor, spring);
    if (Dot(settled_ - before, sought_) < 0) FallBack(anchor, before, spring, stretch);
    return stretch;
  }

  // R/Kc of the settled tip was `sought_` at `before`, and the tip has come back from there. The slow tip
  // goes back with it, at most as far as the bur: then what is left is less than the plain spring's.
  void FallBack(const dvec3& anchor, const dvec3& before, const Spring& spring,
                dvec3& stretch) noexcept {
    const double length = std::sqrt(Dot(sought_, sought_));
    const dvec3 way = sought_ / length;
    const double was = Dot(before - anchor, way), is = Dot(settled_ - anchor, way);
    const double left = was > 0 ? Clamped(is / was, 0, 1) : 0;
    const double excess = Dot(stretch * spring.gain - (tip_ - settled_), way) - length * left;
    const double lead = spring.gain - (1 - spring.shock);
    const double ahead = Dot(slow_ - anchor, way);
    if (!(excess > 0) || !(ahead > 0) || !(lead > 0)) return;
    const double back = LowerOf(excess / lead, ahead);
    slow_ -= way * back;
    stretch -= way * (back * lead / spring.gain);
  }

  // Shortens what the slow and the quick tip differ from the tip by, until the stretch is in the ball.
  void StopAtTip(const dvec3& anchor, dvec3& stretch) noexcept {
    const dvec3 e = tip_ - anchor, lag = stretch - e;
    if (!(Dot(stretch, lag) > 0)) return;
    const double share = Clamped(-Dot(e, lag) / Dot(lag, lag), 0, 1);
    slow_ = tip_ + (slow_ - tip_) * share;
    quick_ = tip_ + (quick_ - tip_) * share;
    stretch = e + lag * share;
  }

  double kc_, tick_s_, play_m_, cell_m_ = 0, unit_s_ = 0, gain_from_ = 0;
  dvec3 tip_{0};
  dvec3 slow_{0}, quick_{0};  // x and f
  dvec3 settled_{0};          // follows the tip at the length of the play
  dvec3 sought_{0};           // R/Kc of the last tick, for the settled tip
  bool seen_ = true;          // the tick's tip, by Follow
  bool fresh_ = true;         // nothing has resisted since
};

}  // namespace

double LeadStiffness(double kc, double b) noexcept {
  return kc * GainIn(b, kGain * kc * UnitOf(kc));
}

std::unique_ptr<ForceLaw> MakeLeadMaxwell(const LawParams& params) {
  return std::make_unique<LeadMaxwell>(params);
}

}  // namespace enamel::haptics
