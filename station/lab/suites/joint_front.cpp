#include "station/lab/suites/joint_front.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>

#include "common/fidelity/felt.h"
#include "common/fidelity/series.h"
#include "common/haptics/uniform_material.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr double kCut_m_per_s = 0.43e-3;  // the paper's
constexpr int kCouplingTicks = 4000;

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

std::vector<JointPoint> MeasureJointFront(
    const JointAxes& axes, const std::function<void(const char*, size_t, size_t)>& progress) {
  auto Says = [&](const char* what) {
    return [&progress, what](size_t done, size_t all) {
      if (progress) progress(what, done, all);
    };
  };
  std::vector<TimedCase> ticks;
  for (const VoxelCase& v : axes.ticks) ticks.push_back(v.tick);
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
    for (size_t t = 0; t < axes.ticks.size(); ++t) {
      if (axes.ticks[t].rate_hz != m.rate_hz) continue;
      const Interval& more = laws_more[f.rate][f.law + 1];
      JointPoint p{axes.ticks[t].voxel_nm,
                   m.rate_hz,
                   axes.laws[f.law],
                   {times[t].mean_us + more, times[t].p99_us + more}};
      // Where the grid lies and what the hand does are independent, so the errors add in squares.
      double of_voxel = 0;
      for (const auto& [voxel_nm, off] : axes.force_errors)
        if (voxel_nm == p.voxel_nm) of_voxel = off;
      p.felt_error = std::hypot(std::sqrt(f.error2 / f.tool2), of_voxel);
      p.felt_error_rms_n =
          p.felt_error * std::sqrt(f.tool2 / static_cast<double>(axes.ways_m.size()));
      p.proved = Proved(SpecOf(m, p.law.law, axes.b_n_s_per_m, kCut_m_per_s));
      p.is_default =
          p.voxel_nm == axes.default_voxel_nm && p.law.law == haptics::kDefaultLaw && f.rate == 0;
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
  const JointPoint* best = nullptr;
  for (const JointPoint& p : points) {
    if (!p.proved || p.tick.p99_us.high > std::min(budget_us, 1e6 / p.rate_hz)) continue;
    if (best == nullptr || p.felt_error < best->felt_error ||
        (p.felt_error == best->felt_error && p.tick.mean_us.value < best->tick.mean_us.value))
      best = &p;
  }
  return best;
}

std::string NextHalvings(const std::vector<JointPoint>& points, const JointPoint& from) {
  const JointPoint *finer = nullptr, *faster = nullptr;
  for (const JointPoint& p : points) {
    if (p.law.law != from.law.law || p.law.estimator != from.law.estimator) continue;
    if (p.rate_hz == from.rate_hz && p.voxel_nm < from.voxel_nm &&
        (finer == nullptr || p.voxel_nm > finer->voxel_nm))
      finer = &p;
    if (p.voxel_nm == from.voxel_nm && p.rate_hz > from.rate_hz &&
        (faster == nullptr || p.rate_hz < faster->rate_hz))
      faster = &p;
  }
  auto Buys = [&](const JointPoint& p) {
    const double points_less = 100 * (from.felt_error - p.felt_error);
    const std::string what = " points of felt error";
    if (std::fabs(points_less) < 0.01) return "less than 0.01" + what;
    return points_less > 0 ? F(points_less, "%.2f") + what
                           : "nothing: " + F(-points_less, "%.2f") + " more" + what;
  };
  std::string text = "From voxels of " + F(from.voxel_nm * 1e-3, "%g") + " um at " +
                     F(from.rate_hz, "%g") + " Hz, felt " + F(100 * from.felt_error, "%.1f") +
                     " % off: ";
  if (finer != nullptr)
    text += "voxels of " + F(finer->voxel_nm * 1e-3, "%g") + " um cost " +
            F(finer->tick.mean_us.value - from.tick.mean_us.value, "%.1f") + " us more a tick (" +
            F(finer->tick.mean_us.value, "%.1f") + ", 95 % " + F(finer->tick.mean_us.low, "%.1f") +
            " to " + F(finer->tick.mean_us.high, "%.1f") + ") and buy " + Buys(*finer);
  else
    text += "no finer voxel was measured";
  if (faster != nullptr)
    text += "; " + F(faster->rate_hz, "%g") + " Hz cost " +
            F(100 * (faster->load() - from.load()), "%.1f") + " % more of a core and buy " +
            Buys(*faster);
  return text + ".";
}

}  // namespace enamel::station::lab
