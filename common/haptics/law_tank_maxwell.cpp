#include <cmath>
#include <cstdint>

#include "common/haptics/count_estimator.h"
#include "common/haptics/coupling.h"
#include "common/haptics/gated_mobility.h"
#include "common/haptics/hand_stiffness.h"

namespace enamel::haptics {
namespace {

// Tuning: one set for every device, material and hand, found with `enamel-lab qualify --suite
// hand` and `--suite random`. tau = tr B / (3 Kc) is the plain coupling's time constant: no time
// here is longer than a share of it, so that soft tissue is not held up by what hard tissue needs.
struct Tuning {
  double cap_moving = 2.5;       // largest gate while counts arrive ...
  double cap_hurried = 6;        // ... and where the fast speed says the force is far too high
  double hurried_above = 1.5;    // "far": r of the fast speed
  double cap_silent = 15;        // once the tip is silent
  double cross_threshold = 0.5;  // beta: cross force, relative to B v, that opens the gate
  double smooth_s = 0.06, smooth_share = 0.1;  // of force and mean speed: the lesser of the two
  double window_share = 0.3, window_min_s = 0.23, window_max_s = 0.6;
  double silence_share = 0.04, silence_min_s = 0.04;
  double rest_below = 1e-3;    // fade at which the slow estimator starts afresh
  double anchor_share = 0.15;  // mu
  double anchor_lowpass_s = 0.004;
  double deviator_gain = 0.7;  // turns e toward B v when B is anisotropic
  double gate_tau_s = 0.05;    // below this tau the gate gives way to the plain coupling
  double soft_opening = 0.3;   // share of the gate's opening in a hand that is not known stiff
  double at_once_cells = 1.5;  // a stretch off by less than this is set at once,
  double slew_cells = 1.7;     // more by so much a tick that, the tip's own way included, no tick's
  double least_slew_cells = 0.2;  // change of force is beyond Kc (v T + sqrt(3) delta)
  double left_behind = 5;  // an axis without a count for so many times its due was left behind
  double telling_m =
      7.5e-6;  // cells of at least this size for judging the hand: 4 of them are what a rest
               // point must move by to tell, and a slow estimate is off by 8 um at a turn
  double finest_m = 2e-6;                  // speed is read from cells of at least this size
  double off_share = 0.12, off_cells = 1;  // "off": more than this of the stretch, and of a cell
};
constexpr Tuning kTuning;

// Gated Maxwell coupling whose rest point may also be moved away from the tip, on the credit of the
// energy tank in the guard (guard.h).
//
// Two laws in one, by what the hand is (hand_stiffness.h):
//  * In a soft hand, or one not yet known, the force makes the speed: the gated coupling
//    (law_gated_maxwell.cpp), gate along on a slow estimate of speed, opened less far.
//  * In a stiff hand the speed makes the force: the rest point is set so that e = B q / Kc, q the
//    fast estimate (TurningAxis), by Aim. A steady cut then has no encoder ripple: the rest point
//    takes up each count. A stroke that turns is followed as fast as counts show it.
// Relax alone is P e with 0 <= P <= I as for every anchored law; Aim is not, and the tank pays.
class TankMaxwell final : public ForceLaw {
 public:
  explicit TankMaxwell(const LawParams& params) : params_(params), grid_(GridOf(params)) {
    Reset(dvec3(0));
  }

  bool anchored() const noexcept override { return true; }
  bool slips() const noexcept override { return true; }
  dvec3 speed_m_per_s() const noexcept override { return fast_; }

  void Reset(const dvec3& tip_m) noexcept override {
    for (int i = 0; i < 3; ++i) {
      axes_[i].Reset(Seen(i, tip_m[i]));
      turning_[i].Reset(Seen(i, tip_m[i]));
    }
    gaps_.Clear();
    hand_.Reset();
    tip_ = tip_m;
    tip_moved_ = dvec3(0);
    time_s_ = 0;
    anchor_known_ = observe_ = estimate_ = smooth_force_ = silent_ = false;
    fade_ = 0;
    anchor_ = anchor_speed_ = smooth_ = slow_force_ = slow_ = fast_ = dvec3(0);
  }

  void BeginTick(const dvec3& tip_m) noexcept override {
    tip_moved_ = tip_m - tip_;
    tip_ = tip_m;
    time_s_ += params_.tick_s;
    observe_ = estimate_ = smooth_force_ = true;
  }

  dvec3 Relax(const dvec3& e_m, const Sym3& b, double dt_s) noexcept override {
    double s = params_.kc_n_per_m * dt_s;
    if (!(s > 0)) return e_m;
    if (observe_) Observe(tip_ - e_m);
    double trace = b.Trace();
    if (!(trace > 0)) return dvec3(0);
    double mean_b = trace / 3, tau = mean_b / params_.kc_n_per_m;
    if (estimate_) Estimate(tau);
    dvec3 bv = b * slow_ + slow_ * (kFreeDamping * mean_b);
    double power = Dot(slow_, bv);
    bool moving = power > 1e-24 * mean_b;
    dvec3 force = e_m * params_.kc_n_per_m;
    double along = moving ? Dot(slow_, force) : 0;
    Gate gate = {SilentCap(), SilentCap()};
    if (along > 0) gate = GateOf(e_m, force, b, bv, along, power, mean_b, tau);
    dvec3 e = RelaxedStretch(b, mean_b, slow_, moving ? power : 0, gate.along, gate.across, s, e_m);
    if (moving) {
      double k = kTuning.deviator_gain * dt_s / tau;
      TurnToward(bv, k / (1 + k), e);
    }
    if (along > 0) {
      DropSlowAxes(bv, bv * (Dot(slow_, e) / power), params_.kc_n_per_m, params_.resolution_m, e);
    }
    return SpendBeforeGuard(e_m, e, params_.resolution_m);
  }

  dvec3 Aim(const dvec3& e_m, const Sym3& b) noexcept override {
    if (!(b.Trace() > 0) || estimate_) return e_m;
    double kc = params_.kc_n_per_m, cell = Cell();
    dvec3 wanted = b * fast_ / kc;
    double longest = params_.peak_force_n / kc, wanted2 = Dot(wanted, wanted);
    if (params_.peak_force_n > 0 && wanted2 > longest * longest) {
      wanted *= longest / std::sqrt(wanted2);
      wanted2 = longest * longest;
    }
    dvec3 off = wanted - e_m;
    double distance = std::sqrt(Dot(off, off));
    double size = std::sqrt(HigherOf(wanted2, Dot(e_m, e_m)));
    hand_.Off(off, distance > kTuning.off_share * size + kTuning.off_cells * cell, params_.tick_s);
    double reach = distance, once = kTuning.at_once_cells * cell;
    // Off by no more than this tick's counts: three at once are 1.73 cells, and setting what they moved
    // back changes no force at all.
    const dvec3 change = off + tip_moved_;
    const bool counts_alone = Dot(change, change) <= once * once;
    if (distance > once && !counts_alone) reach = LowerOf(distance, Slew(cell));
    if (!(distance > 0) || !(hand_.trust() > 0)) return e_m;
    dvec3 step = off * (hand_.trust() * reach / distance);
    hand_.Moved(-step);
    return e_m + step;
  }

  void VisitState(StateArchive& archive) override {
    archive(axes_, turning_, gaps_, tip_, tip_moved_, anchor_, anchor_speed_, smooth_, slow_force_,
            slow_, fast_, time_s_, fade_, anchor_known_, observe_, estimate_, smooth_force_,
            silent_, counted_);
    hand_.VisitState(archive);
  }

 private:
  struct Gate {
    double along, across;
  };

  double Cell() const noexcept { return HigherOf(grid_.x, HigherOf(grid_.y, grid_.z)); }

  double Slew(double cell) const noexcept {
    double way =
        std::sqrt(Dot(fast_, fast_)) * params_.tick_s - std::sqrt(Dot(tip_moved_, tip_moved_));
    return HigherOf(kTuning.least_slew_cells * cell, kTuning.slew_cells * cell + way);
  }

  // Cells that speed is read from. Counts say when a line was crossed; where an encoder makes many in a tick they say
  // only that a tick has passed, and a hand's tremor turns them back and forth. So several cells of a fine
  // encoder are read as one. The stretch, and the force with it, keep the encoder's own resolution.
  static dvec3 GridOf(const LawParams& params) noexcept {
    dvec3 grid = params.resolution_m;
    for (int i = 0; i < 3; ++i) {
      if (!(grid[i] > 0) || !(grid[i] < kTuning.finest_m)) continue;
      const double cells = kTuning.finest_m / grid[i];
      grid[i] *= cells < 1e6 ? static_cast<double>(static_cast<int64_t>(cells + 0.5)) : 1e6;
    }
    return grid;
  }

  // Where the axis is seen: the tip, or the middle of the grid's cell that it is in.
  double Seen(int axis, double tip_m) const noexcept {
    const double g = grid_[axis];
    if (g == params_.resolution_m[axis]) return tip_m;
    const double n = tip_m / g;
    if (!(n > -1e15 && n < 1e15)) return tip_m;
    auto cell = static_cast<int64_t>(n);
    if (n < static_cast<double>(cell)) --cell;
    return (static_cast<double>(cell) + 0.5) * g;
  }

  double SilentCap() const noexcept {
    if (!silent_) return kTuning.cap_moving;
    return kTuning.cap_moving + (kTuning.cap_silent - kTuning.cap_moving) * (1 - fade_);
  }

  Gate GateOf(const dvec3& e, const dvec3& force, const Sym3& b, const dvec3& bv, double along,
              double power, double mean_b, double tau) noexcept {
    double r = along / power, cap = SilentCap();
    double across2 = Dot(force, SolveShifted(b, kFreeDamping * mean_b, force)) / power - r * r;
    double r_across = across2 > 0 ? std::sqrt(across2) / kTuning.cross_threshold : 0;
    double slow_r = SlowRatio(force, power, tau);
    if (slow_r > 1 && !silent_) {
      // The slow estimates say the force is too high; only as far as the fast speed agrees.
      double fast_power = Dot(fast_, b * fast_);
      double fast_r = fast_power > 0 ? Dot(fast_, force) / fast_power : 0;
      if (fast_r > 0 && fast_r < slow_r) slow_r = HigherOf(1, fast_r);
      if (!(fast_r > 0) || fast_r >= kTuning.hurried_above) cap = kTuning.cap_hurried;
    }
    Gate gate;
    gate.along = GateAlong(slow_r, cap);
    gate.across = r_across > 1 ? GateAcross(r_across, cap)
                               : StillGate(e - bv * (r / params_.kc_n_per_m), params_.resolution_m);
    // Where tau is short the plain coupling is fast enough, and a gate could only be late.
    double tau2 = tau * tau, gated = tau2 / (tau2 + kTuning.gate_tau_s * kTuning.gate_tau_s);
    double opening = gated;
    // Tremor would hold a half-open gate off its mean force; it is let through as the gated law does.
    if (!silent_ && !hand_.swinging()) {
      opening *= kTuning.soft_opening + (1 - kTuning.soft_opening) * hand_.trust();
    }
    gate.along = 1 + (gate.along < 1 ? gated : opening) * (gate.along - 1);
    if (gate.across > 1) gate.across = 1 + opening * (gate.across - 1);
    return gate;
  }

  void Observe(const dvec3& anchor) noexcept {
    observe_ = false;
    if (anchor_known_) {
      double k = params_.tick_s / (kTuning.anchor_lowpass_s + params_.tick_s);
      anchor_speed_ += ((anchor - anchor_) / params_.tick_s - anchor_speed_) * k;
    }
    anchor_ = anchor;
    anchor_known_ = true;
    counted_ = false;
    for (int i = 0; i < 3; ++i) {
      const double seen = Seen(i, tip_[i]);
      counted_ |= axes_[i].Update(time_s_, seen, anchor[i], grid_[i]);
      turning_[i].Update(time_s_, seen, grid_[i]);
    }
    if (counted_) gaps_.Count(time_s_);
  }

  // The hand's velocity by both estimators, and what hand it is. Once per tick, in the first
  // material met.
  void Estimate(double tau) noexcept {
    estimate_ = false;
    double window = Clamped(kTuning.window_share * tau, LowerOf(kTuning.window_min_s, tau),
                            kTuning.window_max_s);
    double patience = HigherOf(kTuning.silence_share * tau, LowerOf(kTuning.silence_min_s, tau));
    double smooth_s = LowerOf(kTuning.smooth_s, kTuning.smooth_share * tau);
    double fastest = 0, fastest_delta = 0, most = 0, since_any = 1e9;
    slow_ = dvec3(0);
    for (const AxisEstimator& axis : axes_) since_any = LowerOf(since_any, axis.SinceLast(time_s_));
    for (int i = 0; i < 3; ++i) {
      double delta = grid_[i], since = axes_[i].SinceLast(time_s_);
      if (axes_[i].size() == 0) continue;
      double correction = 0, mean = AxisSpeed(i, window, smooth_s, &correction);
      double speed = std::fabs(mean);
      // An axis that had fallen silent before the newest count of any says nothing about a stop.
      double says = speed * SilenceFade(QuietTime(delta, speed) + patience, since - since_any);
      if (says > most) {
        most = says;
        fastest = speed;
        fastest_delta = delta;
      }
      slow_[i] = (mean + correction) * SilenceFade(QuietTime(delta, speed) + patience, since);
    }
    // The tip is silent when even its fastest axis should have made a count by now.
    fade_ = SilenceFade(gaps_.Quiet(QuietTime(fastest_delta, fastest)) + patience, since_any);
    slow_ *= fade_;
    EstimateFast();
    HandStiffness::Tick tick{tip_moved_, slow_, counted_, false};
    // What a first count says is the most that the speed may be, and no way that the tip is known to go.
    for (int i = 0; i < 3; ++i) {
      if (axes_[i].size() < 2) tick.slow_speed_m_per_s[i] = 0;
    }
    for (TurningAxis& axis : turning_) tick.swings |= axis.TakeSwing();
    hand_.Step(tick, HigherOf(Cell(), kTuning.telling_m), params_.tick_s);
    bool still = Dot(fast_, fast_) == 0;
    if (still && fade_ < kTuning.rest_below) Rest();
    silent_ = fade_ < 1;
    if (!silent_ && still && hand_.trust() > 0.5) {
      silent_ = true;
      fade_ = 0;
    }
  }

  // The axis that counts most often betrays a stop for all of them, unless the others have gone on for
  // long without it: a hand that has turned off along another axis has not stopped.
  void EstimateFast() noexcept {
    double most = 0, lead = 1, since_any = 1e9;
    for (const TurningAxis& axis : turning_)
      since_any = LowerOf(since_any, axis.SinceLast(time_s_));
    for (int i = 0; i < 3; ++i) {
      double delta = grid_[i], fade = turning_[i].Fade(time_s_, delta);
      fast_[i] = turning_[i].speed() * fade;
      double often = std::fabs(turning_[i].speed()) / delta;
      const double without = turning_[i].SinceLast(time_s_) - since_any;
      if (without > kTuning.left_behind * turning_[i].Due(delta)) continue;
      if (often > most) {
        most = often;
        lead = fade;
      }
    }
    fast_ *= lead;
  }

  double AxisSpeed(int i, double window_s, double smooth_s, double* correction) noexcept {
    AxisEstimator& axis = axes_[i];
    if (axis.size() == 1) {
      return smooth_[i] = FirstGuess(axes_, i, time_s_, grid_[i], params_.tick_s);
    }
    constexpr int kEnds = 2;
    double mean = axis.Mean(window_s, kEnds);
    *correction = kTuning.anchor_share * (anchor_speed_[i] - axis.AnchorMean(window_s, kEnds));
    if (axis.size() <= kWindowIntervals) return smooth_[i] = mean;
    double k = params_.tick_s / (smooth_s + params_.tick_s);
    return smooth_[i] += (mean - smooth_[i]) * k;
  }

  // r from the smoothed force.
  double SlowRatio(const dvec3& force, double power, double tau) noexcept {
    if (smooth_force_) {
      smooth_force_ = false;
      double smooth_s = LowerOf(kTuning.smooth_s, kTuning.smooth_share * tau);
      slow_force_ += (force - slow_force_) * (params_.tick_s / (smooth_s + params_.tick_s));
    }
    double r = Dot(slow_, slow_force_) / power;
    return r > 0 ? r : 0;
  }

  void Rest() noexcept {
    for (AxisEstimator& axis : axes_) axis.Rest();
    gaps_.Clear();
  }

  LawParams params_;
  dvec3 grid_;  // GridOf
  AxisEstimator axes_[3];
  TurningAxis turning_[3];
  GapRecord gaps_;
  HandStiffness hand_;
  dvec3 tip_{0}, tip_moved_{0}, anchor_{0}, anchor_speed_{0}, smooth_{0}, slow_force_{0}, slow_{0},
      fast_{0};
  double time_s_ = 0, fade_ = 0;
  bool anchor_known_ = false, observe_ = false, estimate_ = false, smooth_force_ = false,
       silent_ = false, counted_ = false;
};

}  // namespace

std::unique_ptr<ForceLaw> MakeTankMaxwell(const LawParams& params) {
  return std::make_unique<TankMaxwell>(params);
}

}  // namespace enamel::haptics
