#include <algorithm>
#include <cmath>
#include <memory>

#include "station/lab/cutting/force_error.h"
#include "station/lab/suites/joint_front.h"
#include "station/lab/suites/suites.h"

// Voxel, loop rate, law and estimator together: the cost of a whole tick, and the error in the hand.
namespace enamel::station::lab {
namespace {

constexpr size_t kTicks = 400;
// In a round. Of each tick the shorter counts, or another program's turn would be in it.
constexpr int kRuns = 2;

std::vector<int32_t> Voxels(bool quick) {
  if (quick) return {100'000, 50'000, 25'000};
  return {200'000, 100'000, 50'000, 25'000};
}

std::vector<haptics::EstimatorKind> Estimators(bool quick) {
  // One of each kind: a difference and a window.
  if (quick)
    return {haptics::EstimatorKind::kBackwardDifference, haptics::EstimatorKind::kFoawBestFit};
  std::vector<haptics::EstimatorKind> out;
  for (const auto& e : haptics::VelocityEstimators()) out.push_back(e.kind);
  return out;
}

// The headline's cut: cylinder r 0.6 x 4 mm, half sunk, 5 mm/s.
CutCase CaseAt(int32_t voxel_nm, double rate_hz) {
  CutCase c = BurCases()[0];
  c.voxel_nm = voxel_nm;
  c.rate_hz = static_cast<uint32_t>(std::lround(rate_hz));
  return c;
}

JointAxes AxesOf(SuiteContext& c, const DeviceModel& m) {
  JointAxes axes = FrontAxes(m,
                             c.options.quick ? std::vector<double>{1000, 4000}
                                             : std::vector<double>{1000, 2000, 4000, 8000},
                             Estimators(c.options.quick));
  for (int32_t nm : Voxels(c.options.quick))
    axes.voxels.push_back(
        {nm, MeasureForceError(BurCases()[0].bur, nm), [nm](const DeviceModel& at) {
           auto path = std::make_shared<CutPath>(MakeCutPath(CaseAt(nm, at.rate_hz), kTicks));
           return TimedCase{[path] {
             const TickCost cost = TimeTicks(*path, kRuns);
             return Spread{cost.mean_us, cost.p99_us};
           }};
         }});
  axes.threads = c.options.threads;
  return axes;
}

std::string Text(const Interval& i) {
  return F(i.value, "%.1f") + " (" + F(i.low, "%.1f") + "-" + F(i.high, "%.1f") + ")";
}

Table FrontTable(const std::vector<JointPoint>& points, const DeviceModel& m) {
  Table t;
  t.title = "Joint front on " + m.title + ": voxel, rate, law and estimator";
  t.head = {"law",
            "voxel um",
            "rate Hz",
            "tick us, mean (95 %)",
            "p99 us (95 %)",
            "of a core %",
            "felt error %",
            "felt error N RMS",
            ""};
  const JointPoint* chosen = nullptr;
  std::vector<const JointPoint*> shown;
  for (const JointPoint& p : points) {
    if (p.is_default) chosen = &p;
    if (p.on_front || p.is_default) shown.push_back(&p);
  }
  std::sort(shown.begin(), shown.end(),
            [](auto* a, auto* b) { return a->felt_error > b->felt_error; });
  for (const JointPoint* p : shown)
    t.rows.push_back({p->law.Name(), F(p->voxel_nm * 1e-3, "%g"), F(p->rate_hz, "%g"),
                      Text(p->tick.mean_us), Text(p->tick.p99_us), F(100 * p->load(), "%.1f"),
                      F(100 * p->felt_error, "%.2f"), F(p->felt_error_rms_n),
                      !p->is_default ? ""
                      : p->on_front  ? "default"
                                     : "default, dominated"});
  const JointPoint* best = BestWithin(points, kNoBudget_us);
  t.note =
      (best != nullptr ? WhyBest(points, *best, kNoBudget_us) + " " : std::string()) +
      (chosen != nullptr ? NextHalvings(points, *chosen) + " " : std::string()) +
      std::to_string(points.size()) + " combinations, " + std::to_string(shown.size()) +
      " shown: the front of felt error, tick and share of a core among laws with a proof, and "
      "the default. Tick: cut, engagement, law, force and hash; cylinder r 0.6 x 4 mm, half "
      "sunk, 5 mm/s; median of nine rounds in turns, each tick the shorter of two runs. Felt: a "
      "generated hand of 1 N/mm at 0.2 "
      "mm/s in B 6.5 N s/mm against an ideal tool; to it the error that the voxel makes of the "
      "bur's force is added in squares, as a hand feels it that does not give.";
  return t;
}

}  // namespace

void RunFrontSuite(SuiteContext& c) {
  for (const DeviceModel& m : c.findings.models) {
    std::vector<JointPoint> points = MeasureJointFront(AxesOf(c, m), c.progress);
    c.findings.tables.push_back(FrontTable(points, m));
    c.findings.fronts.push_back({m.name, m.title, std::move(points)});
  }
}

}  // namespace enamel::station::lab
