#include <cmath>

#include "common/haptics/count_estimator.h"
#include "common/haptics/coupling.h"
#include "common/haptics/gated_mobility.h"

namespace enamel::haptics {
namespace {

// Tuning of the gated Maxwell coupling: one set for every device, material and hand, found with
// `enamel-lab qualify --suite random`. Dimensionless unless the name says otherwise.
struct Tuning {
  double cap_moving = 2.5;       // largest gate while counts arrive
  double cap_silent = 15;        // largest gate once the tip is silent
  double force_smooth_s = 0.06;  // of the force the gate looks at: tremor must not be rectified
  double cross_threshold = 0.5;  // beta: cross force, relative to B v, that opens the gate
  double window_share = 0.3;     // look back this share of B/Kc ...
  double window_min_s = 0.23, window_max_s = 0.6;  // ... within these
  double smooth_s = 0.06;  // of the mean speed: a swinging hand must not open and close the gate
  double silence_share = 0.12;  // share of B/Kc that the release is patient for,
  double silence_min_s = 0.02;  // and at least this
  double rest_below = 1e-3;     // fade at which the estimator starts afresh
  double anchor_share = 0.15;   // mu
  double anchor_lowpass_s = 0.004;
  double deviator_gain = 0.7;  // turns e toward B v when B is anisotropic
};
constexpr Tuning kTuning;

// Gated Maxwell coupling. The plain coupling needs B/Kc to build its force up because the anchor
// already runs at R/B while R is still too small. Here the anchor is slowed while R is below B v
// (v: estimate of the hand's speed) and quickened while it is above, so force rises at the slope
// limit Kc v and still settles at R = B v. M = gated mobility, symmetric positive semi-definite, so
// e' = (I + Kc T M)^-1 e is P e with P = P^T, 0 <= P <= I: the passivity proof of coupling.h is
// untouched. What follows (turning e, dropping a slow axis) only ever takes from e, and the guard
// in coupling.h judges the step as a whole.
class GatedMaxwell final : public ForceLaw {
 public:
  explicit GatedMaxwell(const LawParams& params) : params_(params) { Reset(dvec3(0)); }

  bool anchored() const noexcept override { return true; }

  void Reset(const dvec3& tip_m) noexcept override {
    for (int i = 0; i < 3; ++i) axes_[i].Reset(tip_m[i]);
    gaps_.Clear();
    tip_ = tip_m;
    time_s_ = 0;
    anchor_known_ = false;
    anchor_speed_ = smooth_ = slow_force_ = v_ = dvec3(0);
  }

  void BeginTick(const dvec3& tip_m) noexcept override {
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
    double mean_b = trace / 3;
    if (estimate_) Estimate(mean_b / params_.kc_n_per_m);
    dvec3 bv = b * v_ + v_ * (kFreeDamping * mean_b);
    double power = Dot(v_, bv);
    bool moving = power > 1e-24 * mean_b;
    dvec3 force = e_m * params_.kc_n_per_m;
    double along = moving ? Dot(v_, force) : 0;
    double cap = silent_ ? kTuning.cap_silent : kTuning.cap_moving;
    double gate_along = cap, gate_across = cap;
    if (along > 0) {
      double r = along / power;
      double across2 = Dot(force, SolveShifted(b, kFreeDamping * mean_b, force)) / power - r * r;
      double r_across = across2 > 0 ? std::sqrt(across2) / kTuning.cross_threshold : 0;
      gate_along = GateAlong(SlowRatio(force, power), cap);
      gate_across = r_across > 1
                        ? GateAcross(r_across, cap)
                        : StillGate(e_m - bv * (r / params_.kc_n_per_m), params_.resolution_m);
    }
    dvec3 e = RelaxedStretch(b, mean_b, v_, moving ? power : 0, gate_along, gate_across, s, e_m);
    if (moving) {
      double k = kTuning.deviator_gain * params_.kc_n_per_m * dt_s / mean_b;
      TurnToward(bv, k / (1 + k), e);
    }
    if (along > 0) {
      DropSlowAxes(bv, bv * (Dot(v_, e) / power), params_.kc_n_per_m, params_.resolution_m, e);
    }
    return SpendBeforeGuard(e_m, e, params_.resolution_m);
  }

  void VisitState(StateArchive& archive) override {
    archive(axes_, gaps_, tip_, anchor_, anchor_speed_, smooth_, slow_force_, v_, time_s_,
            anchor_known_, observe_, estimate_, smooth_force_, silent_);
  }

 private:
  void Observe(const dvec3& anchor) noexcept {
    observe_ = false;
    if (anchor_known_) {
      double k = params_.tick_s / (kTuning.anchor_lowpass_s + params_.tick_s);
      anchor_speed_ += ((anchor - anchor_) / params_.tick_s - anchor_speed_) * k;
    }
    anchor_ = anchor;
    anchor_known_ = true;
    bool counted = false;
    for (int i = 0; i < 3; ++i) {
      counted |= axes_[i].Update(time_s_, tip_[i], anchor[i], params_.resolution_m[i]);
    }
    if (counted) gaps_.Count(time_s_);
  }

  // The hand's velocity, faded by silence: v_, silent_. Once per tick, in the first material met.
  void Estimate(double time_constant_s) noexcept {
    estimate_ = false;
    double window =
        Clamped(kTuning.window_share * time_constant_s, kTuning.window_min_s, kTuning.window_max_s);
    double patience = kTuning.silence_share * time_constant_s;
    if (patience < kTuning.silence_min_s) patience = kTuning.silence_min_s;
    double fastest = 0, fastest_delta = 0, since_any = 1e9;
    v_ = dvec3(0);
    for (int i = 0; i < 3; ++i) {
      double delta = params_.resolution_m[i], since = axes_[i].SinceLast(time_s_);
      since_any = LowerOf(since_any, since);
      if (axes_[i].size() == 0) continue;
      double correction = 0, mean = AxisSpeed(i, window, &correction), speed = std::fabs(mean);
      if (speed > fastest) {
        fastest = speed;
        fastest_delta = delta;
      }
      v_[i] = (mean + correction) * SilenceFade(QuietTime(delta, speed) + patience, since);
    }
    // The tip is silent when even its fastest axis should have made a count by now.
    double fade = SilenceFade(gaps_.Quiet(QuietTime(fastest_delta, fastest)) + patience, since_any);
    v_ *= fade;
    silent_ = fade < 1;
    if (fade < kTuning.rest_below) Rest();
  }

  double AxisSpeed(int i, double window_s, double* correction) noexcept {
    AxisEstimator& axis = axes_[i];
    if (axis.size() == 1) {
      return smooth_[i] = FirstGuess(axes_, i, time_s_, params_.resolution_m[i], params_.tick_s);
    }
    double mean = axis.Mean(window_s);
    *correction = kTuning.anchor_share * (anchor_speed_[i] - axis.AnchorMean(window_s));
    if (axis.size() <= kWindowIntervals) return smooth_[i] = mean;
    double k = params_.tick_s / (kTuning.smooth_s + params_.tick_s);
    return smooth_[i] += (mean - smooth_[i]) * k;
  }

  // r from the smoothed force.
  double SlowRatio(const dvec3& force, double power) noexcept {
    if (smooth_force_) {
      smooth_force_ = false;
      slow_force_ +=
          (force - slow_force_) * (params_.tick_s / (kTuning.force_smooth_s + params_.tick_s));
    }
    double r = Dot(v_, slow_force_) / power;
    return r > 0 ? r : 0;
  }

  void Rest() noexcept {
    for (AxisEstimator& axis : axes_) axis.Rest();
    gaps_.Clear();
  }

  LawParams params_;
  AxisEstimator axes_[3];
  GapRecord gaps_;
  dvec3 tip_{0}, anchor_{0}, anchor_speed_{0}, smooth_{0}, slow_force_{0}, v_{0};
  double time_s_ = 0;
  bool anchor_known_ = false, observe_ = false, estimate_ = false, smooth_force_ = false,
       silent_ = false;
};

}  // namespace

std::unique_ptr<ForceLaw> MakeGatedMaxwell(const LawParams& params) {
  return std::make_unique<GatedMaxwell>(params);
}

}  // namespace enamel::haptics
