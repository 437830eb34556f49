#include <array>
#include <cmath>
#include <cstdint>

#include "common/haptics/coupling.h"

namespace enamel::haptics {
namespace {

// Tuning of the gated Maxwell coupling: one set for every device, material and hand, found with
// `enamel-station qualify --suite random`. Dimensionless unless the name says otherwise.
struct Tuning {
  double gate_power_slope = 5;   // s: how fast the gate opens above r = 1
  double cap_moving = 2.5;       // largest gate while counts arrive
  double cap_silent = 15;        // largest gate once the tip is silent
  double force_smooth_s = 0.06;  // of the force the gate looks at: tremor must not be rectified
  double cross_threshold = 0.5;  // beta: cross force, relative to B v, that opens the gate
  double window_share = 0.3;     // look back this share of B/Kc ...
  double window_min_s = 0.23, window_max_s = 0.6;  // ... within these
  int window_intervals = 5;                        // and at least this many counts
  double spacing_s = 0.01;  // counts closer than this are one event, so 64 always span the window
  double smooth_s = 0.06;   // of the mean speed: a swinging hand must not open and close the gate
  double start_counts = 1;  // cells an axis is taken to have moved while others made more counts
  double silence_counts =
      1.4;  // kappa: cells' worth of time without a count that is not yet silence
  double silence_gaps = 1.03;  // nor is this many times the longest of the last gaps between counts
  double silence_share = 0.12;  // plus this share of B/Kc, which is how patient the release may be,
  double silence_min_s = 0.02;  // and at least this
  double rest_below = 1e-3;     // fade at which the estimator starts afresh
  double anchor_share = 0.15;   // mu
  double anchor_lowpass_s = 0.004;
  double deviator_gain = 0.7;  // turns e toward B v when B is anisotropic
  double still_gate = 0.1;     // gate across while the cross stretch is within the encoder's cell
  double still_cells = 1.05;   // "within": this many half cells ...
  double still_ramp = 0.5;     // ... and fully outside this many later
  double slow_axis_cells = 1;  // an axis whose target force is below this many Kc delta is slow
  double slow_axis_reach = 1.02;  // its cross stretch beyond this many half cells is let go at once
};
constexpr Tuning kTuning;

double Clamped(double v, double lo, double hi) noexcept { return v < lo ? lo : v > hi ? hi : v; }
double Lower(double a, double b) noexcept { return a < b ? a : b; }

// Time, encoder edge and anchor at which one axis made a count.
struct CountEvent {
  double time_s, edge_m, anchor_m;
};

// Tip velocity of one axis from its count events. An event is the crossing of an edge other than
// the one crossed last, so that dithering on one edge is silence. Fixed memory: 64 events.
class AxisEstimator {
 public:
  void Reset(double tip_m) noexcept {
    tip_ = tip_m;
    size_ = 0;
    has_edge_ = false;
    restart_s_ = -1;
  }

  // Whether the axis made a count.
  bool Update(double time_s, double tip_m, double anchor_m, double delta_m) noexcept {
    if (tip_m == tip_) return false;
    // Tips are cell middles: the edge just crossed is half a cell behind the new middle.
    double edge = tip_m > tip_ ? tip_m - 0.5 * delta_m : tip_m + 0.5 * delta_m;
    sign_ = tip_m > tip_ ? 1 : -1;
    tip_ = tip_m;
    if (has_edge_ && std::fabs(edge - last().edge_m) < 0.25 * delta_m) return false;
    if (size_ == 0) restart_s_ = time_s;
    stale_ = true;
    if (size_ > 2 && time_s - At(1).time_s < kTuning.spacing_s) {
      events_[static_cast<size_t>((head_ - 1 + kEvents) % kEvents)] = {time_s, edge, anchor_m};
    } else {
      Push({time_s, edge, anchor_m});
    }
    return true;
  }

  // Mean speed over the window that ends at the newest event, before any silence. Requires: two
  // events.
  double Mean(double window_s) noexcept {
    Refresh(window_s);
    return mean_m_per_s_;
  }
  // The anchor's mean speed over the same window.
  double AnchorMean(double window_s) noexcept {
    Refresh(window_s);
    return anchor_mean_m_per_s_;
  }
  // After one count only bounds are known: it came at most kappa cells of travel ago, and since the
  // motion began at start_s the axis has moved about `cells`.
  double FirstGuess(double time_s, double start_s, double cells, double delta_m,
                    double tick_s) const noexcept {
    double recent = kTuning.silence_counts * delta_m / (SinceLast(time_s) + tick_s);
    double started = cells * delta_m / (time_s - start_s + tick_s);
    return sign_ * Lower(recent, started);
  }

  // The tip rests: what was counted before says nothing about the next motion.
  void Rest() noexcept { size_ = 0; }

  double SinceLast(double time_s) const noexcept {
    return size_ == 0 ? 1e9 : time_s - last().time_s;
  }
  int size() const noexcept { return size_; }
  double restart_s() const noexcept { return restart_s_; }

 private:
  static constexpr int kEvents = 64;

  void Refresh(double window_s) noexcept {
    if (!stale_ && window_s == window_s_) return;
    stale_ = false;
    window_s_ = window_s;
    // The shortest look back that satisfies both bounds, found from the last one: O(1) per count.
    const CountEvent& newest = At(0);
    auto Enough = [&](int back) {
      return newest.time_s - At(back).time_s >= window_s && back >= kTuning.window_intervals;
    };
    back_ = back_ < 1 ? 1 : back_ > size_ - 1 ? size_ - 1 : back_;
    while (back_ > 1 && Enough(back_ - 1)) --back_;
    while (back_ + 1 < size_ && !Enough(back_)) ++back_;
    const CountEvent& oldest = At(back_);
    double span = newest.time_s - oldest.time_s;
    mean_m_per_s_ = span > 0 ? (newest.edge_m - oldest.edge_m) / span : 0;
    anchor_mean_m_per_s_ = span > 0 ? (newest.anchor_m - oldest.anchor_m) / span : 0;
  }
  const CountEvent& At(int back) const noexcept {
    return events_[static_cast<size_t>((head_ - 1 - back + 2 * kEvents) % kEvents)];
  }
  const CountEvent& last() const noexcept { return At(0); }
  void Push(const CountEvent& e) noexcept {
    events_[static_cast<size_t>(head_)] = e;
    head_ = (head_ + 1) % kEvents;
    if (size_ < kEvents) ++size_;
    has_edge_ = true;
  }

  std::array<CountEvent, kEvents> events_{};
  int head_ = 0, size_ = 0, back_ = 1;
  double tip_ = 0, restart_s_ = -1, sign_ = 0;
  double mean_m_per_s_ = 0, anchor_mean_m_per_s_ = 0, window_s_ = -1;
  bool has_edge_ = false, stale_ = true;
};

// The last gaps between counts of whichever axis: on an oblique way the tip counts more often than
// its fastest axis, and so betrays a stop sooner.
class GapRecord {
 public:
  void Clear() noexcept {
    size_ = 0;
    last_s_ = -1;
  }
  void Count(double time_s) noexcept {
    if (last_s_ >= 0) {
      gaps_[static_cast<size_t>(at_)] = time_s - last_s_;
      at_ = (at_ + 1) % kGaps;
      if (size_ < kGaps) ++size_;
      longest_s_ = 0;
      for (double gap : gaps_) longest_s_ = gap > longest_s_ ? gap : longest_s_;
    }
    last_s_ = time_s;
  }
  // A time without a count that is not yet silence, at most `quiet_s`.
  double Quiet(double quiet_s) const noexcept {
    return size_ < kGaps ? quiet_s : Lower(quiet_s, kTuning.silence_gaps * longest_s_);
  }

 private:
  static constexpr int kGaps = 8;
  std::array<double, kGaps> gaps_{};
  int at_ = 0, size_ = 0;
  double last_s_ = -1, longest_s_ = 0;
};

// r^4 below 1 holds the anchor back while the force is below what the speed calls for; above 1 the
// gate opens linearly up to `cap`.
double GateAlong(double r, double cap) noexcept {
  if (r < 1) return (r * r) * (r * r);
  double g = 1 + kTuning.gate_power_slope * (r - 1);
  return g < cap ? g : cap;
}
double GateAcross(double r, double cap) noexcept {
  if (r <= 1) return 1;
  double g = 1 + kTuning.gate_power_slope * (r - 1);
  return g < cap ? g : cap;
}

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
    // B is often singular (a flat face resists one direction only): the free directions get a
    // mobility a million times the mean, which is as good as free in one tick.
    dvec3 bv = b * v_ + v_ * (1e-6 * mean_b);
    double power = Dot(v_, bv);
    bool moving = power > 1e-24 * mean_b;
    dvec3 force = e_m * params_.kc_n_per_m;
    double along = moving ? Dot(v_, force) : 0;
    double cap = silent_ ? kTuning.cap_silent : kTuning.cap_moving;
    double gate_along = cap, gate_across = cap;
    if (along > 0) {
      double r = along / power;
      double across2 = Dot(force, SolveShifted(b, 1e-6 * mean_b, force)) / power - r * r;
      double r_across = across2 > 0 ? std::sqrt(across2) / kTuning.cross_threshold : 0;
      gate_along = GateAlong(SlowRatio(force, power), cap);
      gate_across =
          r_across > 1 ? GateAcross(r_across, cap) : StillGate(e_m - bv * (r / params_.kc_n_per_m));
    }
    dvec3 e = Apply(b, mean_b, moving ? power : 0, gate_along, gate_across, s, e_m);
    if (moving) TurnToward(bv, mean_b, dt_s, e);
    if (along > 0) DropSlowAxes(bv, power, e);
    return SpendBeforeGuard(e_m, e);
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
      since_any = Lower(since_any, since);
      if (axes_[i].size() == 0) continue;
      double correction = 0, mean = AxisSpeed(i, window, &correction), speed = std::fabs(mean);
      if (speed > fastest) {
        fastest = speed;
        fastest_delta = delta;
      }
      v_[i] = (mean + correction) * Fade(Quiet(delta, speed) + patience, since);
    }
    // The tip is silent when even its fastest axis should have made a count by now.
    double fade = Fade(gaps_.Quiet(Quiet(fastest_delta, fastest)) + patience, since_any);
    v_ *= fade;
    silent_ = fade < 1;
    if (fade < kTuning.rest_below) Rest();
  }

  double AxisSpeed(int i, double window_s, double* correction) noexcept {
    AxisEstimator& axis = axes_[i];
    if (axis.size() == 1) return smooth_[i] = FirstGuess(i);
    double mean = axis.Mean(window_s);
    *correction = kTuning.anchor_share * (anchor_speed_[i] - axis.AnchorMean(window_s));
    if (axis.size() <= kTuning.window_intervals) return smooth_[i] = mean;
    double k = params_.tick_s / (kTuning.smooth_s + params_.tick_s);
    return smooth_[i] += (mean - smooth_[i]) * k;
  }

  double FirstGuess(int i) const noexcept {
    double start = 1e9;
    bool others_know = false;
    for (const AxisEstimator& axis : axes_) {
      if (axis.size() > 0) start = Lower(start, axis.restart_s());
      others_know |= axis.size() > 1;
    }
    return axes_[i].FirstGuess(time_s_, start, others_know ? kTuning.start_counts : 2,
                               params_.resolution_m[i], params_.tick_s);
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

  static double Quiet(double delta_m, double speed_m_per_s) noexcept {
    return kTuning.silence_counts * delta_m / (speed_m_per_s + 1e-12);
  }
  static double Fade(double quiet_s, double since_s) noexcept {
    double f = quiet_s / (since_s + 1e-9);
    if (!(f < 1)) return 1;
    double cube = f * f * f;
    return cube * cube;
  }

  // (I + s M)^-1 e with M = g_across A + (g_along - g_across) v v^T / (v^T B v).
  dvec3 Apply(const Sym3& b, double mean_b, double power, double along, double across, double s,
              const dvec3& e) const noexcept {
    // Without the rank-one part: (I + s g A)^-1 = B (B + s g I)^-1 (B regularised).
    double shift = s * across;
    auto base = [&](const dvec3& x) {
      dvec3 y = SolveShifted(b, shift + 1e-6 * mean_b, x);
      return b * y + y * (1e-6 * mean_b);
    };
    dvec3 e0 = base(e);
    if (power == 0) return e0;
    // Sherman-Morrison for the rank-one part; base is symmetric.
    double c = s * (along - across) / power;
    dvec3 v0 = base(v_);
    return e0 - v0 * (c * Dot(v_, e0) / (1 + c * Dot(v_, v0)));
  }

  // A cross stretch inside the encoder's own cell is most likely not there: left nearly alone, the
  // counts of a slow axis swing it half a cell to both sides of nothing.
  double StillGate(const dvec3& across_m) const noexcept {
    double cells = 0;
    for (int i = 0; i < 3; ++i) {
      double q = 2 * std::fabs(across_m[i]) / params_.resolution_m[i];
      cells = q > cells ? q : cells;
    }
    double share = (cells - kTuning.still_cells) / kTuning.still_ramp;
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    return kTuning.still_gate + (1 - kTuning.still_gate) * share;
  }

  // An axis the hand hardly moves along makes a count now and then, which would show as a whole Kc
  // delta: what is more than half a cell off is let go at once.
  void DropSlowAxes(const dvec3& bv, double power, dvec3& e) const noexcept {
    dvec3 across = e - bv * (Dot(v_, e) / power);
    for (int i = 0; i < 3; ++i) {
      double half = 0.5 * params_.resolution_m[i];
      if (std::fabs(bv[i]) > kTuning.slow_axis_cells * 2 * half * params_.kc_n_per_m) continue;
      double excess = std::fabs(across[i]) - kTuning.slow_axis_reach * half;
      if (!(excess > 0) || excess > half || !(across[i] * e[i] > 0)) continue;
      double take = Lower(excess, std::fabs(e[i]));
      e[i] -= e[i] > 0 ? take : -take;
    }
  }

  // Where the guard would shorten a step along e (it stalls once |e|^2 < delta/2 sum |e_i|), each
  // axis may still come to within half a cell of the tip: w_i <= |e_i| - delta_i/2 passes the guard
  // whole, since e.w - sum delta_i |w_i| / 2 >= w.w. Takes whichever step frees more energy.
  dvec3 SpendBeforeGuard(const dvec3& e, const dvec3& relaxed) const noexcept {
    dvec3 w = e - relaxed;
    double factor = GuardFactor(e, w, params_.resolution_m);
    if (factor >= 1) return relaxed;
    dvec3 apart(0);
    for (int i = 0; i < 3; ++i) {
      double reach = std::fabs(e[i]) - 0.5 * params_.resolution_m[i];
      double want = e[i] > 0 ? w[i] : -w[i];
      if (!(reach > 0) || !(want > 0)) continue;
      double take = want < reach ? want : reach;
      apart[i] = e[i] > 0 ? take : -take;
    }
    return Dot(apart, e) > factor * Dot(w, e) ? e - apart : relaxed;
  }

  // With anisotropic B the direction of e settles only at B/Kc; turning it toward B v keeps its
  // length from growing, so the step still shortens the spring.
  void TurnToward(const dvec3& bv, double mean_b, double dt_s, dvec3& e) const noexcept {
    double length = std::sqrt(Dot(e, e)), norm = std::sqrt(Dot(bv, bv));
    if (!(length > 0) || !(norm > 0)) return;
    dvec3 u = bv / norm;
    if (!(Dot(u, e) > 0)) return;
    double k = kTuning.deviator_gain * params_.kc_n_per_m * dt_s / mean_b;
    e += (u * length - e) * (k / (1 + k));
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
