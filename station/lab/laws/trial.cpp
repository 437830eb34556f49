#include "station/lab/laws/trial.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/fidelity/series.h"

namespace enamel::station::lab {
namespace {

using haptics::Contact;
using haptics::Coupling;
using haptics::CouplingOutput;
using haptics::CouplingParams;

class TrialMaterial final : public haptics::Material {
 public:
  explicit TrialMaterial(const TrialSpec& spec) : spec_(spec), now_(spec.b_n_s_per_m) {}
  void SetTime(double t_s) {
    for (const TissueStep& step : spec_.tissue) {
      if (t_s >= step.at_s) now_ = Sym3::Isotropic(step.b_n_s_per_m);
    }
  }
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    Contact c;
    c.damping_n_s_per_m = now_;
    c.engaged = !now_.IsZero();
    c.clearance_m = 1;  // uniform: no surface to step over, the whole tick is one step
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
  const Sym3& now() const { return now_; }

 private:
  const TrialSpec& spec_;
  Sym3 now_;
};

// A trial that has not settled by then is measured unsettled.
constexpr double kLongestTrial_s = 120;

std::unique_ptr<Hand> MakeHand(const TrialSpec& s, double stop_s) {
  LineMotion motion{s.direction,      s.speed_m_per_s, stop_s,     s.reverse_s,
                    s.start_offset_m, s.tremor_m,      s.tremor_hz};
  if (s.hand == HandKind::kVelocity) return std::make_unique<VelocityHand>(motion);
  if (s.hand == HandKind::kForce) {
    dvec3 push = s.b_n_s_per_m * s.direction * s.speed_m_per_s;
    double n = glm::length(push);
    return std::make_unique<ForceHand>(n > 0 ? push / n : s.direction, n, s.hand_mass_kg,
                                       s.hand_damping_n_s_per_m, stop_s);
  }
  return std::make_unique<ImpedanceHand>(motion, s.hand_stiffness_n_per_m, s.hand_mass_kg,
                                         s.hand_damping_n_s_per_m);
}

// Mean and variance over a window without storing it.
struct Moments {
  double n = 0, sum = 0, squares = 0;
  void Add(double v) {
    n += 1;
    sum += v;
    squares += v * v;
  }
  double mean() const { return n > 0 ? sum / n : 0; }
  double variance() const { return n > 0 ? std::max(0.0, squares / n - mean() * mean()) : 0; }
};

// Least squares of equally spaced samples: x per sample.
dvec3 SlopePerSample(const std::vector<dvec3>& x) {
  double n = static_cast<double>(x.size()), mid = (n - 1) / 2, tt = n * (n * n - 1) / 12;
  dvec3 slope(0);
  for (size_t i = 0; i < x.size(); ++i)
    slope += (x[i] - x[0]) * ((static_cast<double>(i) - mid) / tt);
  return slope;
}

// Largest distance from the line through the samples.
double DeviationFromLine(const std::vector<dvec3>& x) {
  if (x.size() < 3) return 0;
  double n = static_cast<double>(x.size()), mid = (n - 1) / 2, worst = 0;
  dvec3 mean(0), slope = SlopePerSample(x);
  for (const dvec3& p : x) mean += p / n;
  for (size_t i = 0; i < x.size(); ++i) {
    worst = std::max(worst, glm::length(x[i] - mean - slope * (static_cast<double>(i) - mid)));
  }
  return worst;
}

// The balance of the theorem over the true motion, and the energy actually taken out.
struct EnergyBalance {
  double sum = 0, lowest = 0, handed = 0, taken = 0;
  void Add(const dvec3& resisting_n, const dvec3& dx, double b_over_t, double c) {
    double work = Dot(resisting_n, dx);
    sum +=
        work + b_over_t * Dot(dx, dx) + c * (std::fabs(dx.x) + std::fabs(dx.y) + std::fabs(dx.z));
    lowest = std::min(lowest, sum);
    handed += work;
    taken = std::max(taken, -handed);
  }
};

class TrialRun {
 public:
  explicit TrialRun(const TrialSpec& spec)
      : spec_(spec),
        settle_(spec.settle_s > 0 ? spec.settle_s : SettleTime(spec)),
        stop_(settle_ + spec.window_s),
        hand_(MakeHand(spec, stop_)),
        plant_(spec.plant, *hand_, spec.start_offset_m),
        material_(spec),
        coupling_(Params(spec)) {
    coupling_.Reset(plant_.Read());
    target_ = spec.b_n_s_per_m * spec.direction * spec.speed_m_per_s;
    m_.target_n = glm::length(target_);
    along_ = m_.target_n > 0 ? target_ / m_.target_n : spec.direction;
    for (auto* list : {&positions_, &anchors_, &in_hand_})
      list->reserve(static_cast<size_t>(spec.window_s / spec.plant.tick_s) + 2);
    double kc = spec.law.kc_n_per_m;
    m_.rise90_floor_s = spec.speed_m_per_s > 0 ? 0.9 * m_.target_n / (kc * spec.speed_m_per_s) : 0;
  }

  Measurement Run() {
    // A force hand that lets go is thrown back by the spring it held, so there is no release to
    // measure.
    double wait = std::min(3 * Tau() + 1, std::max(0.0, kLongestTrial_s - stop_));
    double end = spec_.hand == HandKind::kForce || !spec_.measure_release ? stop_ : stop_ + wait;
    while (plant_.time_s() < end && !m_.unstable) {
      if (plant_.TickLost())
        Held();
      else
        OneTick();
      if (released_ && plant_.time_s() > stop_ + 0.3 * Tau() + 0.2) break;
    }
    Finish();
    return std::move(m_);
  }

 private:
  static CouplingParams Params(const TrialSpec& spec) {
    CouplingParams p;
    p.law = spec.law;
    p.peak_force_n = spec.peak_force_n;
    p.delay_ticks = spec.plant.delay_ticks;
    return p;
  }
  double Tau() const { return spec_.b_n_s_per_m.Trace() / 3 / spec_.law.kc_n_per_m; }

  void OneTick() {
    material_.SetTime(plant_.time_s());
    CouplingOutput out = coupling_.Tick(plant_.Read(), 1, material_);
    Measure(-out.force_sent_n, out.anchor_m);
    dvec3 before = plant_.tip_m();
    plant_.Step(out.force_sent_n);
    if (positions_.size() > in_hand_.size()) in_hand_.push_back(plant_.in_hand_n());
    balance_.Add(-plant_.sent_n(), plant_.tip_m() - before,
                 spec_.plant.damping_n_s_per_m / plant_.last_tick_s(), spec_.plant.friction_n);
    ++m_.ticks;
  }

  void Held() {
    dvec3 before = plant_.tip_m();
    plant_.StepHeld();
    balance_.Add(-plant_.sent_n(), plant_.tip_m() - before,
                 spec_.plant.damping_n_s_per_m / plant_.last_tick_s(), spec_.plant.friction_n);
    ++m_.ticks;
  }

  void Measure(const dvec3& r, const dvec3& anchor) {
    double t = plant_.time_s(), along = Dot(r, along_);
    // A metre away: no device reaches so far.
    if (!std::isfinite(along) || !(glm::length(plant_.tip_m()) < 1)) {
      m_.unstable = true;
      return;
    }
    if (spec_.trace_s > 0 && t >= next_trace_) {
      m_.trace.push_back({t, along, Dot(plant_.tip_m() - spec_.start_offset_m, spec_.direction),
                          Dot(anchor - spec_.start_offset_m, spec_.direction)});
      next_trace_ += spec_.trace_s;
    }
    if (m_.rise90_s < 0 && along >= 0.9 * m_.target_n) m_.rise90_s = t;
    if (t >= settle_ && t < stop_) Window(r, along, anchor);
    if (t >= stop_) AfterStop(r, along, t);
  }

  void Window(const dvec3& r, double along, const dvec3& anchor) {
    if (positions_.empty()) smooth_ = along;
    positions_.push_back(plant_.tip_m());
    anchors_.push_back(anchor);
    dvec3 off = r - target_;
    for (int i = 0; i < 3; ++i) {
      m_.error_max_n = std::max(m_.error_max_n, std::fabs(off[i]));
      mean_[i].Add(r[i]);
    }
    error2_.Add(Dot(off, off));
    ripple_.Add(along);
    // A first-order low-pass at 20 Hz: the part above it is felt as vibration, not as force.
    double k = 2 * M_PI * 20 * spec_.plant.tick_s;
    smooth_ += (along - smooth_) * (k / (1 + k));
    fast_.Add(along - smooth_);
    low_ = std::min(low_, along);
    high_ = std::max(high_, along);
  }

  void AfterStop(const dvec3& r, double along, double t) {
    if (!stopped_) {
      stopped_ = true;
      m_.release_level_n = 0.1 * ripple_.mean();
    }
    m_.kick_n = std::max(m_.kick_n, -along);
    // The guard may leave Kc delta / 2 per axis (and rounding); that still counts as released.
    double left = 0.5001 * spec_.law.kc_n_per_m * spec_.plant.resolution_m;
    bool inside = std::fabs(r.x) <= left && std::fabs(r.y) <= left && std::fabs(r.z) <= left;
    if (m_.release10_s < 0 && (inside || glm::length(r) <= m_.release_level_n))
      m_.release10_s = t - stop_;
    released_ = m_.release10_s >= 0;
  }

  void Finish() {
    m_.mean_n = ripple_.mean();
    m_.error_rms_n = std::sqrt(error2_.mean());
    m_.ripple_rms_n = std::sqrt(ripple_.variance());
    m_.ripple_fast_rms_n = std::sqrt(fast_.variance());
    m_.deviation_m = DeviationFromLine(positions_);
    FinishFelt();
    if (anchors_.size() > 2) {
      dvec3 speed = SlopePerSample(anchors_) / spec_.plant.tick_s;
      dvec3 mean(mean_[0].mean(), mean_[1].mean(), mean_[2].mean());
      dvec3 off = material_.now() * speed - mean;
      for (int i = 0; i < 3; ++i)
        m_.anchor_error_n = std::max(m_.anchor_error_n, std::fabs(off[i]));
    }
    if (spec_.hand != HandKind::kVelocity) m_.error_max_n = m_.anchor_error_n;
    m_.energy_min_j = balance_.lowest;
    m_.energy_floor_j = 0;  // every trial starts unloaded: V_0 = 0
    m_.handed_j = balance_.handed;
    m_.extracted_j = balance_.taken;
    m_.violation = balance_.lowest < -1e-12;
    double count = spec_.law.kc_n_per_m * spec_.plant.resolution_m;
    bool moves = spec_.hand == HandKind::kVelocity
                     ? m_.ripple_rms_n > count + 0.05 * m_.target_n
                     : m_.deviation_m > 2.5 * spec_.plant.resolution_m;
    m_.cycle = moves && spec_.tremor_m == 0;
    if (high_ - low_ > 1.5 * spec_.peak_force_n || high_ - low_ > 4 * m_.target_n + 1)
      m_.unstable = true;
  }

  void FinishFelt() {
    if (positions_.size() < 3) return;
    const dvec3 felt = material_.now() * (SlopePerSample(positions_) / spec_.plant.tick_s);
    for (dvec3& r : in_hand_) r -= felt;
    m_.felt_error_rms_n = fidelity::RmsOf(in_hand_);
    m_.felt_error_p95_n = fidelity::WithinOf(in_hand_, 0.95);
  }

  const TrialSpec& spec_;
  double settle_, stop_;
  std::unique_ptr<Hand> hand_;
  Plant plant_;
  TrialMaterial material_;
  Coupling coupling_;
  Measurement m_;
  dvec3 target_{0}, along_{1, 0, 0};
  EnergyBalance balance_;
  Moments mean_[3], error2_, ripple_, fast_;
  std::vector<dvec3> positions_, anchors_, in_hand_;
  double next_trace_ = 0, smooth_ = 0, low_ = 1e300, high_ = -1e300;
  bool stopped_ = false, released_ = false;
};

}  // namespace

double SettleTime(const TrialSpec& spec) {
  double b = spec.b_n_s_per_m.Trace() / 3, compliance = 1 / spec.law.kc_n_per_m;
  if (spec.hand == HandKind::kImpedance) compliance += 1 / spec.hand_stiffness_n_per_m;
  return std::min(kLongestTrial_s - spec.window_s, 2 + std::log(100.0) * b * compliance);
}

Measurement RunTrial(const TrialSpec& spec) { return TrialRun(spec).Run(); }

double IntegrationError(const TrialSpec& spec) {
  TrialSpec fine = spec;
  fine.plant.substeps *= 8;
  auto Way = [](const TrialSpec& s, std::vector<dvec3>* forces, bool replay) {
    double stop = 1;
    std::unique_ptr<Hand> hand = MakeHand(s, stop);
    Plant plant(s.plant, *hand, s.start_offset_m);
    TrialMaterial material(s);
    CouplingParams p;
    p.law = s.law;
    p.peak_force_n = s.peak_force_n;
    Coupling coupling(p);
    coupling.Reset(plant.Read());
    std::vector<dvec3> way;
    int ticks = static_cast<int>(2 * stop / s.plant.tick_s);
    for (int i = 0; i < ticks; ++i) {
      if (!replay) forces->push_back(coupling.Tick(plant.Read(), 1, material).force_sent_n);
      plant.Step((*forces)[static_cast<size_t>(i)]);
      way.push_back(plant.tip_m());
    }
    return way;
  };
  std::vector<dvec3> forces;
  std::vector<dvec3> coarse = Way(spec, &forces, false), finer = Way(fine, &forces, true);
  double worst = 0;
  for (size_t i = 0; i < coarse.size(); ++i)
    worst = std::max(worst, glm::length(coarse[i] - finer[i]));
  return worst;
}

}  // namespace enamel::station::lab
