#include "station/lab/suites/joint_front.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <set>

#include "common/fidelity/felt.h"
#include "common/fidelity/series.h"
#include "common/haptics/uniform_material.h"
#include "station/lab/laws/motions.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr double kCut_m_per_s = 0.43e-3;  // the paper's
constexpr int kCouplingTicks = 4000;
constexpr double kHuman_m_per_s = 0.2e-3, kDuration_s = 12;  // of the hand that works a surface

bool NeedsSpeed(haptics::LawKind law) {
  return !ProvedLaw(law) && law != haptics::LawKind::kVirtualCoupling;
}

// The largest window that the adaptive estimators take, at most 0.128 s.
int WindowAt(double rate_hz) { return std::min(256, static_cast<int>(0.128 * rate_hz)); }

haptics::LawParams LawOf(const DeviceModel& m, const LawChoice& choice) {
  haptics::LawParams p = SpecOf(m, choice.law, 6500, kCut_m_per_s).law;
  p.estimator.kind = choice.estimator;
  p.estimator.window_ticks = WindowAt(m.rate_hz);
  return p;
}

// Law, estimator and output chain without a cut: the mean of many ticks, since one is as short as the clock's own.
TimedCase CouplingCase(const DeviceModel& m, const LawChoice& choice, double b) {
  return {[m, choice, b] {
    haptics::CouplingParams p;
    p.law = LawOf(m, choice);
    p.peak_force_n = m.peak_force_n;
    haptics::Coupling coupling(p);
    haptics::UniformMaterial material(Sym3::Isotropic(b));
    const dvec3 way = glm::normalize(dvec3(1, 2, 3)) * (kCut_m_per_s * m.tick_s());
    std::vector<dvec3> tips(kCouplingTicks);
    for (int i = 0; i < kCouplingTicks; ++i)
      tips[static_cast<size_t>(i)] = CellMiddle(way * static_cast<double>(i), m.resolution_m);
    coupling.Reset(tips[0]);
    const auto from = std::chrono::steady_clock::now();
    for (const dvec3& tip : tips) coupling.Tick(tip, 1, material);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - from;
    return Spread{took.count() / kCouplingTicks, took.count() / kCouplingTicks};
  }};
}

using Rounds = std::vector<std::vector<Spread>>;  // of each case, of each round

Rounds RunInTurns(const std::vector<TimedCase>& cases,
                  const std::function<void(size_t, size_t)>& progress) {
  Rounds out(cases.size());
  size_t done = 0;
  for (int round = 0; round < kRounds; ++round)
    for (size_t i = 0; i < cases.size(); ++i) {
      out[i].push_back(cases[i].run());
      if (progress) progress(++done, cases.size() * kRounds);
    }
  return out;
}

// What the hand gets of one law at one rate.
struct Felt {
  size_t rate, law;
  double error2 = 0, tool2 = 0;
};

fidelity::FeltTrial TrialOf(const JointAxes& axes, const DeviceModel& m) {
  fidelity::FeltTrial trial;
  trial.b_n_s_per_m = Sym3::Isotropic(axes.b_n_s_per_m);
  trial.hand.stiffness_n_per_m = axes.grip_n_per_m;
  trial.hand = SameHand(trial.hand, m.mass_kg);
  trial.delay_ticks = m.delay_ticks;
  return trial;
}

// The right force for each way: no law is in it.
std::vector<fidelity::Series> ToolsAt(const JointAxes& axes, const DeviceModel& m) {
  std::vector<fidelity::Series> out;
  for (const auto& way : axes.ways_m)
    out.push_back(ForceInHand(fidelity::ToolOf(FeltDeviceOf(m)), TrialOf(axes, m), way, true));
  return out;
}

void Feel(const JointAxes& axes, const std::vector<fidelity::Series>& tools, Felt* f) {
  const DeviceModel& m = axes.at_rates[f->rate];
  fidelity::FeltTrial trial = TrialOf(axes, m);
  trial.law = axes.laws[f->law].law;
  trial.estimator = LawOf(m, axes.laws[f->law]).estimator;
  for (size_t i = 0; i < tools.size(); ++i) {
    const double error = fidelity::RmsOf(
        fidelity::Difference(ForceInHand(FeltDeviceOf(m), trial, axes.ways_m[i], false), tools[i]));
    const double right = fidelity::RmsOf(tools[i]);
    f->error2 += error * error;
    f->tool2 += right * right;
  }
}

// The profile's loop carries the rate, and its Kc is passive at it.
bool RunsOn(const DeviceModel& at) {
  const scene::DeviceProfile& own = at.profile;
  return at.rate_hz <= static_cast<double>(own.rate_hz.value) &&
         at.kc_n_per_m > (1 - 1e-9) * static_cast<double>(own.coupling_mn_per_mm.value);
}

bool Fits(const JointPoint& p, double budget_us) {
  return p.proved && p.runs && p.tick.p99_us.high <= std::min(budget_us, 1e6 / p.rate_hz);
}

// "0.50 points of felt error".
std::string Points(double share) {
  const double points = 100 * std::fabs(share);
  return (points < 0.01 ? "less than 0.01" : F(points, "%.2f")) + " points of felt error";
}
std::string Buys(const JointPoint& from, const JointPoint& to) {
  const double less = from.felt_error - to.felt_error;
  if (less > -1e-4) return Points(less);
  return "nothing: " + F(-100 * less, "%.2f") + " more points of felt error";
}

std::string VoxelText(const JointPoint& from, const JointPoint& to) {
  const Interval more = to.tick.mean_us - from.tick.mean_us;
  const bool finer = to.voxel_nm < from.voxel_nm;
  std::string text = "voxels of " + F(to.voxel_nm * 1e-3, "%g") + " um ";
  if (!more.apart())
    text += "cost as much, within noise,";
  else
    text += (more.value > 0 ? "cost " : "save ") + F(std::fabs(more.value), "%.1f") + " us " +
            (more.value > 0 ? "more " : "") + "a tick (" + F(to.tick.mean_us.value, "%.1f") +
            ", 95 % " + F(to.tick.mean_us.low, "%.1f") + " to " + F(to.tick.mean_us.high, "%.1f") +
            ")";
  return text + (finer ? " and buy " + Buys(from, to)
                       : " and lose " + Points(to.felt_error - from.felt_error));
}

std::string RateText(const JointPoint& from, const JointPoint& to) {
  const double per_us = 1e-4;  // of a core in percent, at 1 Hz
  const Interval &a = from.tick.mean_us, &b = to.tick.mean_us;
  auto Load = [&](const Interval& us, double hz) {
    return Interval{us.value * hz * per_us, us.low * hz * per_us, us.high * hz * per_us};
  };
  const Interval more = Load(b, to.rate_hz) - Load(a, from.rate_hz);
  std::string text = F(to.rate_hz, "%g") + " Hz" + (to.runs ? "" : ", beyond this profile's loop,");
  text += more.apart() ? " cost " + F(more.value, "%.1f") + " % more of a core"
                       : " cost as much, within noise,";
  return text + " and buy " + Buys(from, to);
}

}  // namespace

Interval IntervalOf(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return {v[v.size() / 2], v[1], v[v.size() - 2]};
}

Interval operator+(const Interval& a, const Interval& b) {
  const double value = a.value + b.value;
  return {value, value - std::hypot(a.value - a.low, b.value - b.low),
          value + std::hypot(a.high - a.value, b.high - b.value)};
}

Interval operator-(const Interval& a, const Interval& b) {
  return a + Interval{-b.value, -b.high, -b.low};
}

std::vector<TickTime> TimeInTurns(const std::vector<TimedCase>& cases,
                                  const std::function<void(size_t, size_t)>& progress) {
  std::vector<TickTime> out;
  for (const std::vector<Spread>& rounds : RunInTurns(cases, progress)) {
    std::vector<double> means, p99s;
    for (const Spread& s : rounds) {
      means.push_back(s.mean);
      p99s.push_back(s.p99);
    }
    out.push_back({IntervalOf(std::move(means)), IntervalOf(std::move(p99s))});
  }
  return out;
}

std::vector<Interval> MoreThanFirst_us(const std::vector<TimedCase>& cases,
                                       const std::function<void(size_t, size_t)>& progress) {
  const Rounds rounds = RunInTurns(cases, progress);
  std::vector<Interval> out;
  for (const std::vector<Spread>& one : rounds) {
    std::vector<double> more;
    for (size_t r = 0; r < one.size(); ++r) more.push_back(one[r].mean - rounds[0][r].mean);
    out.push_back(IntervalOf(std::move(more)));
  }
  return out;
}

std::string LawChoice::Name() const {
  const haptics::EstimatorEntry* with = haptics::FindEstimator(estimator);
  return std::string(haptics::FindLaw(law)->name) +
         (with == nullptr ? "" : " / " + std::string(with->name));
}

std::vector<LawChoice> LawChoices(const std::vector<haptics::EstimatorKind>& estimators) {
  std::vector<LawChoice> out;
  for (const haptics::LawEntry& law : haptics::ForceLaws()) {
    if (!NeedsSpeed(law.kind) || estimators.empty()) {
      out.push_back({law.kind});
      continue;
    }
    for (haptics::EstimatorKind e : estimators) out.push_back({law.kind, e});
  }
  return out;
}

JointAxes FrontAxes(const DeviceModel& device, const std::vector<double>& rates_hz,
                    const std::vector<haptics::EstimatorKind>& estimators) {
  JointAxes axes;
  std::set<double> rates(rates_hz.begin(), rates_hz.end());
  rates.insert(device.rate_hz);
  for (double rate : rates) axes.at_rates.push_back(AtRate(device, rate, rate > device.rate_hz));
  axes.laws = LawChoices(estimators);
  for (uint64_t seed : {1, 2})
    axes.ways_m.push_back(WanderingMotion(kHuman_m_per_s, kDuration_s, seed).way_m);
  return axes;
}

std::vector<JointPoint> MeasureJointFront(
    const JointAxes& axes, const std::function<void(const char*, size_t, size_t)>& progress) {
  auto Says = [&](const char* what) {
    return [&progress, what](size_t done, size_t all) {
      if (progress) progress(what, done, all);
    };
  };
  struct At {
    const FrontVoxel* voxel;
    size_t rate;
  };
  std::vector<At> at;
  std::vector<TimedCase> ticks;
  for (const FrontVoxel& voxel : axes.voxels)
    for (size_t r = 0; r < axes.at_rates.size(); ++r) {
      TimedCase tick = voxel.tick(axes.at_rates[r]);
      if (!tick.run) continue;
      at.push_back({&voxel, r});
      ticks.push_back(std::move(tick));
    }
  const std::vector<TickTime> times = TimeInTurns(ticks, Says("front: ticks"));
  std::vector<std::vector<Interval>> laws_more;
  for (const DeviceModel& m : axes.at_rates) {
    std::vector<TimedCase> couplings = {CouplingCase(m, {}, axes.b_n_s_per_m)};
    for (const LawChoice& law : axes.laws)
      couplings.push_back(CouplingCase(m, law, axes.b_n_s_per_m));
    laws_more.push_back(MoreThanFirst_us(couplings, Says("front: laws")));
  }
  std::vector<std::vector<fidelity::Series>> tools(axes.at_rates.size());
  ParallelFor(tools.size(), axes.threads,
              [&](size_t r) { tools[r] = ToolsAt(axes, axes.at_rates[r]); });
  std::vector<Felt> felt;
  for (size_t r = 0; r < axes.at_rates.size(); ++r)
    for (size_t l = 0; l < axes.laws.size(); ++l) felt.push_back({r, l});
  std::atomic<size_t> done{0};
  ParallelFor(felt.size(), axes.threads, [&](size_t i) {
    Feel(axes, tools[felt[i].rate], &felt[i]);
    if (progress) progress("front: hands", ++done, felt.size());
  });
  std::vector<JointPoint> out;
  for (const Felt& f : felt) {
    const DeviceModel& m = axes.at_rates[f.rate];
    for (size_t t = 0; t < at.size(); ++t) {
      if (at[t].rate != f.rate) continue;
      const FrontVoxel& voxel = *at[t].voxel;
      const Interval& more = laws_more[f.rate][f.law + 1];
      JointPoint p{voxel.voxel_nm,
                   m.rate_hz,
                   axes.laws[f.law],
                   {times[t].mean_us + more, times[t].p99_us + more}};
      // Where the grid lies and what the hand does are independent, so the errors add in squares.
      p.hand_error = std::sqrt(f.error2 / f.tool2);
      p.voxel_error = voxel.force_error;
      p.felt_error = std::hypot(p.hand_error, p.voxel_error);
      p.felt_error_rms_n =
          p.felt_error * std::sqrt(f.tool2 / static_cast<double>(axes.ways_m.size()));
      p.proved = Proved(SpecOf(m, p.law.law, axes.b_n_s_per_m, kCut_m_per_s));
      p.runs = RunsOn(m);
      p.is_default = p.voxel_nm == axes.planned_voxel_nm && p.rate_hz == axes.planned_rate_hz &&
                     p.law.law == axes.planned_law;
      out.push_back(p);
    }
  }
  MarkJointFront(&out);
  return out;
}

void MarkJointFront(std::vector<JointPoint>* points) {
  for (JointPoint& p : *points) {
    p.on_front = p.proved && std::none_of(points->begin(), points->end(), [&](const JointPoint& q) {
                   const double a[] = {q.felt_error, q.tick.mean_us.value, q.load()},
                                b[] = {p.felt_error, p.tick.mean_us.value, p.load()};
                   bool no_worse = q.proved, better = false;
                   for (size_t i = 0; i < 3; ++i) {
                     no_worse = no_worse && a[i] <= b[i];
                     better = better || a[i] < b[i];
                   }
                   return no_worse && better;
                 });
  }
}

const JointPoint* BestWithin(const std::vector<JointPoint>& points, double budget_us) {
  double least = std::numeric_limits<double>::infinity();
  for (const JointPoint& p : points)
    if (Fits(p, budget_us)) least = std::min(least, p.felt_error);
  const JointPoint* best = nullptr;
  for (const JointPoint& p : points) {
    if (!Fits(p, budget_us) || p.felt_error > least + kSameError) continue;
    if (best == nullptr || p.tick.mean_us.value < best->tick.mean_us.value) best = &p;
  }
  return best;
}

std::string WhyBest(const std::vector<JointPoint>& points, const JointPoint& best,
                    double budget_us) {
  const JointPoint* planned = nullptr;
  for (const JointPoint& p : points)
    if (p.is_default) planned = &p;
  const auto fit = std::count_if(points.begin(), points.end(),
                                 [&](const JointPoint& p) { return Fits(p, budget_us); });
  std::string text = "Voxels of " + F(best.voxel_nm * 1e-3, "%g") + " um, law " + best.law.Name() +
                     ", " + F(best.rate_hz, "%g") + " Hz: of " + std::to_string(fit) +
                     " combinations that have a proof, that the device's loop carries and whose "
                     "slowest hundredth of ticks fits, the cheapest of those felt best, " +
                     F(100 * best.felt_error, "%.2f") + " % off";
  if (planned == &best) return text + ". It is what is planned.";
  if (planned != nullptr) text += " (as planned " + F(100 * planned->felt_error, "%.2f") + " %)";
  return text + ".";
}

std::string NextHalvings(const std::vector<JointPoint>& points, const JointPoint& from) {
  const JointPoint *finer = nullptr, *coarser = nullptr, *faster = nullptr;
  for (const JointPoint& p : points) {
    if (p.law.law != from.law.law || p.law.estimator != from.law.estimator) continue;
    if (p.rate_hz == from.rate_hz && p.voxel_nm < from.voxel_nm &&
        (finer == nullptr || p.voxel_nm > finer->voxel_nm))
      finer = &p;
    if (p.rate_hz == from.rate_hz && p.voxel_nm > from.voxel_nm &&
        (coarser == nullptr || p.voxel_nm < coarser->voxel_nm))
      coarser = &p;
    if (p.voxel_nm == from.voxel_nm && p.rate_hz > from.rate_hz &&
        (faster == nullptr || p.rate_hz < faster->rate_hz))
      faster = &p;
  }
  std::string text = "From voxels of " + F(from.voxel_nm * 1e-3, "%g") + " um at " +
                     F(from.rate_hz, "%g") + " Hz, felt " + F(100 * from.felt_error, "%.1f") +
                     " % off: ";
  if (finer != nullptr)
    text += VoxelText(from, *finer);
  else if (coarser != nullptr)
    text += "no finer voxel was measured; " + VoxelText(from, *coarser);
  else
    text += "no other voxel was measured";
  if (faster != nullptr) text += "; " + RateText(from, *faster);
  return text + ".";
}

}  // namespace enamel::station::lab
