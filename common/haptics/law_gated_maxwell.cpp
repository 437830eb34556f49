#include <array>
#include <cmath>
#include <cstdint>

#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

// Tuning of the gated Maxwell coupling: one set for every device, material and hand. Dimensionless
// unless the name says otherwise.
struct Tuning {
  double gate_power_slope = 5;        // s: how fast the gate opens above r = 1
  double cap_moving = 2.5;            // largest gate while counts arrive
  double cap_silent = 15;             // largest gate once the tip is silent
  double cross_threshold = 0.5;       // beta: cross force, relative to B v, that opens the gate
  double window_share = 0.3;          // look back this share of B/Kc ...
  double window_min_s = 0.23, window_max_s = 0.6;   // ... within these
  int window_intervals = 4;           // and at least this many counts
  double silence_counts = 1.7;        // kappa: counts' worth of time without a count that is not yet silence
  double silence_extra_s = 0.06;
  double rest_below = 1e-3;           // fade at which the estimator starts afresh
  double anchor_share = 0.15;         // mu
  double anchor_lowpass_s = 0.004;
  double deviator_gain = 0.7;         // turns e toward B v when B is anisotropic
};
constexpr Tuning kTuning;

// Time, encoder edge and anchor at which one axis made a count.
struct CountEvent {
  double time_s, edge_m, anchor_m;
};

// Tip velocity of one axis from its count events. An event is the crossing of an edge other than the
// one crossed last, so that dithering on one edge is silence. Fixed memory: 32 events.
class AxisEstimator {
 public:
  void Reset(double tip_m) noexcept {
    tip_ = tip_m;
    size_ = 0;
    has_edge_ = false;
    restart_s_ = -1;
  }

  void Update(double time_s, double tip_m, double anchor_m, double delta_m) noexcept {
    if (tip_m == tip_) return;
    // Tips are cell middles: the edge just crossed is half a cell behind the new middle.
    double edge = tip_m > tip_ ? tip_m - 0.5 * delta_m : tip_m + 0.5 * delta_m;
    sign_ = tip_m > tip_ ? 1 : -1;
    tip_ = tip_m;
    if (has_edge_ && std::fabs(edge - last().edge_m) < 0.25 * delta_m) return;
    if (size_ == 0) restart_s_ = time_s;
    Push({time_s, edge, anchor_m});
  }

  // Mean speed over the window that ends at the newest event, before any silence; `anchor_mean` is
  // the anchor's mean speed over the same window. After one count only a bound is known: it has come
  // at most kappa cells of travel ago.
  double Mean(double time_s, double window_s, double delta_m, double tick_s, double* anchor_mean) const noexcept {
    *anchor_mean = 0;
    if (size_ == 0) return 0;
    if (size_ == 1) {
      double recent = kTuning.silence_counts * delta_m / (SinceLast(time_s) + tick_s);
      double started = 2 * delta_m / (time_s - restart_s_ + tick_s);
      return sign_ * (recent < started ? recent : started);
    }
    const CountEvent& newest = At(0);
    int back = 1;
    while (back + 1 < size_ &&
           (newest.time_s - At(back).time_s < window_s || back < kTuning.window_intervals)) {
      ++back;
    }
    const CountEvent& oldest = At(back);
    double span = newest.time_s - oldest.time_s;
    if (!(span > 0)) return 0;
    *anchor_mean = (newest.anchor_m - oldest.anchor_m) / span;
    return (newest.edge_m - oldest.edge_m) / span;
  }

  // The tip rests: what was counted before says nothing about the next motion.
  void Rest() noexcept { size_ = 0; }

  double SinceLast(double time_s) const noexcept { return size_ == 0 ? 1e9 : time_s - last().time_s; }
  int size() const noexcept { return size_; }

 private:
  static constexpr int kEvents = 64;

  const CountEvent& At(int back) const noexcept { return events_[static_cast<size_t>((head_ - 1 - back + 2 * kEvents) % kEvents)]; }
  const CountEvent& last() const noexcept { return At(0); }
  void Push(const CountEvent& e) noexcept {
    events_[static_cast<size_t>(head_)] = e;
    head_ = (head_ + 1) % kEvents;
    if (size_ < kEvents) ++size_;
    has_edge_ = true;
  }

  std::array<CountEvent, kEvents> events_{};
  int head_ = 0, size_ = 0;
  double tip_ = 0, restart_s_ = -1, sign_ = 0;
  bool has_edge_ = false;
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
// e' = (I + Kc T M)^-1 e is P e with 0 <= P <= I: the passivity proof of coupling.h is untouched.
class GatedMaxwell final : public ForceLaw {
 public:
  explicit GatedMaxwell(const LawParams& params) : params_(params) { Reset(dvec3(0)); }

  bool anchored() const noexcept override { return true; }

  void Reset(const dvec3& tip_m) noexcept override {
    for (int i = 0; i < 3; ++i) axes_[i].Reset(tip_m[i]);
    tip_ = tip_m;
    time_s_ = 0;
    anchor_known_ = false;
    anchor_speed_ = dvec3(0);
  }

  void BeginTick(const dvec3& tip_m) noexcept override {
    tip_ = tip_m;
    time_s_ += params_.tick_s;
    fresh_tick_ = true;
  }

  dvec3 Relax(const dvec3& e_m, const Sym3& b, double dt_s) noexcept override {
    double s = params_.kc_n_per_m * dt_s;
    if (!(s > 0)) return e_m;
    if (fresh_tick_) Observe(tip_ - e_m);
    fresh_tick_ = false;
    double trace = b.Trace();
    if (!(trace > 0)) return dvec3(0);
    double mean_b = trace / 3;
    bool silent = false, resting = false;
    dvec3 v = Velocity(mean_b, &silent, &resting);
    if (resting) {
      for (AxisEstimator& axis : axes_) axis.Rest();
    }
    dvec3 force = e_m * params_.kc_n_per_m;
    // B is often singular (a flat face resists one direction only): the free directions get a
    // mobility a million times the mean, which is as good as free in one tick.
    Sym3 regular = b + Sym3::Isotropic(1e-6 * mean_b);
    dvec3 bv = regular * v;
    double power = Dot(v, bv);
    double cap = silent ? kTuning.cap_silent : kTuning.cap_moving;
    dvec3 af = SolveShifted(b, 1e-6 * mean_b, force);  // A F
    double along = Dot(v, force);
    double gate_along = cap, gate_across = cap;
    bool moving = power > 1e-24 * mean_b;
    if (moving && along > 0) {
      double r = along / power;
      double across2 = Dot(force, af) / power - r * r;
      double r_across = across2 > 0 ? std::sqrt(across2) / kTuning.cross_threshold : 0;
      gate_along = GateAlong(r, cap);
      gate_across = GateAcross(r_across, cap);
    }
    dvec3 e = Apply(b, mean_b, v, bv, moving ? power : 0, gate_along, gate_across, s, e_m);
    if (moving) TurnToward(bv, mean_b, dt_s, e);
    return e;
  }

 private:
  void Observe(const dvec3& anchor) noexcept {
    if (anchor_known_) {
      double k = params_.tick_s / (kTuning.anchor_lowpass_s + params_.tick_s);
      anchor_speed_ += ((anchor - anchor_) / params_.tick_s - anchor_speed_) * k;
    }
    anchor_ = anchor;
    anchor_known_ = true;
    for (int i = 0; i < 3; ++i) axes_[i].Update(time_s_, tip_[i], anchor[i], params_.resolution_m[i]);
  }

  dvec3 Velocity(double mean_b, bool* silent, bool* resting) const noexcept {
    double window = kTuning.window_share * mean_b / params_.kc_n_per_m;
    window = window < kTuning.window_min_s ? kTuning.window_min_s : window > kTuning.window_max_s ? kTuning.window_max_s : window;
    dvec3 v(0);
    bool first_counts = axes_[0].size() < 2 && axes_[1].size() < 2 && axes_[2].size() < 2;
    double fastest = 0, fastest_delta = 0, since_any = 1e9;
    for (int i = 0; i < 3; ++i) {
      double delta = params_.resolution_m[i], since = axes_[i].SinceLast(time_s_), anchor_mean;
      since_any = since < since_any ? since : since_any;
      if (axes_[i].size() < (first_counts ? 1 : 2)) continue;
      double mean = axes_[i].Mean(time_s_, window, delta, params_.tick_s, &anchor_mean);
      double correction = axes_[i].size() > 1 ? kTuning.anchor_share * (anchor_speed_[i] - anchor_mean) : 0;
      double speed = std::fabs(mean);
      if (speed > fastest) {
        fastest = speed;
        fastest_delta = delta;
      }
      v[i] = (mean + correction) * Fade(delta, speed, since);
    }
    // The tip is silent when even its fastest axis should have made a count by now.
    double fade = Fade(fastest_delta, fastest, since_any);
    *silent = fade < 1;
    *resting = fade < kTuning.rest_below;
    return v * fade;
  }

  static double Fade(double delta_m, double speed_m_per_s, double since_s) noexcept {
    double f = (kTuning.silence_counts * delta_m / (speed_m_per_s + 1e-12) + kTuning.silence_extra_s) / (since_s + 1e-9);
    f = f < 1 ? f : 1;
    return f * f * f;
  }

  // (I + s M)^-1 e with M = g_across A + (g_along - g_across) v v^T / (v^T B v).
  dvec3 Apply(const Sym3& b, double mean_b, const dvec3& v, const dvec3& bv, double power, double along,
              double across, double s, const dvec3& e) const noexcept {
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
    dvec3 v0 = base(v);
    double denominator = 1 + c * Dot(v, v0);
    (void)bv;
    return e0 - v0 * (c * Dot(v, e0) / denominator);
  }

  // With anisotropic B the direction of e settles only at B/Kc; turning it toward B v keeps its length
  // from growing, so the step still shortens the spring.
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
  dvec3 tip_{0}, anchor_{0}, anchor_speed_{0};
  double time_s_ = 0;
  bool anchor_known_ = false, fresh_tick_ = false;
};

}  // namespace

std::unique_ptr<ForceLaw> MakeGatedMaxwell(const LawParams& params) {
  return std::make_unique<GatedMaxwell>(params);
}

}  // namespace enamel::haptics
