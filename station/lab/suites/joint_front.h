#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/core/core.h"
#include "station/lab/cutting/tick_cost.h"
#include "station/lab/laws/model.h"
#include "station/lab/laws/motions.h"

// One front over all that a practice may choose: voxel, loop rate, law and estimator. `qualify --suite front` and
// `explain` measure it by the same functions and pick by the same ranking (BestWithin); they differ in what is cut
// alone. A choice costs the whole tick. Its error is that of the force in the hand of somebody who works a surface,
// against an ideal tool in the same hand (fidelity/felt.h). The voxel's error of the bur's force is added in squares:
// where the grid lies and what the hand does are independent. A hand that gives would hide most of the second.
//
// Costs are measured when called, and repeated in turns: every case once, then every case again. What else the
// computer does meanwhile is spread over all of them. A figure is the median of kRounds, its interval from the second
// to the last but one: it has the true median in 96.1 % of runs, whatever the distribution.
namespace enamel::station::lab {

inline constexpr int kRounds = 9;

struct Interval {
  double value = 0, low = 0, high = 0;
  // Differs from 0 for certain.
  bool apart() const { return low > 0 || high < 0; }
};
// Median, second, last but one. Requires: kRounds values.
Interval IntervalOf(std::vector<double> rounds);
Interval operator+(const Interval& a, const Interval& b);  // of independent figures
Interval operator-(const Interval& a, const Interval& b);

struct TickTime {
  Interval mean_us, p99_us;  // over a run's ticks
};
// What is timed, in turns: each call of `run` is one run, and gives mean and p99 of its ticks in microseconds.
struct TimedCase {
  std::function<Spread()> run;
};
std::vector<TickTime> TimeInTurns(const std::vector<TimedCase>& cases,
                                  const std::function<void(size_t, size_t)>& progress = {});
// Of each case, how much longer its ticks take than those of the first, taken round by round.
std::vector<Interval> MoreThanFirst_us(const std::vector<TimedCase>& cases,
                                       const std::function<void(size_t, size_t)>& progress = {});

struct LawChoice {
  haptics::LawKind law = haptics::kDefaultLaw;
  haptics::EstimatorKind estimator = haptics::EstimatorKind::kLawsOwn;
  std::string Name() const;  // "eq17 / foaw-best-fit"
};
// Every law; those that need a speed with each of `estimators`.
std::vector<LawChoice> LawChoices(const std::vector<haptics::EstimatorKind>& estimators);

struct JointPoint {
  int32_t voxel_nm = 0;
  double rate_hz = 0;
  LawChoice law;
  TickTime tick;
  double load() const { return tick.mean_us.value * 1e-6 * rate_hz; }  // share of a core
  // Shares of the tool's force: the error in the hand of law and device, the error of the bur's force by the voxel,
  // and both in squares; the last in newtons too.
  double hand_error = 0, voxel_error = 0, felt_error = 0, felt_error_rms_n = 0;
  bool proved = false;      // the theorem covers law and Kc
  bool runs = false;        // the device's own loop carries the rate, with its own Kc
  bool is_default = false;  // as planned
  bool on_front = false;
};

// What is cut, at one voxel.
struct FrontVoxel {
  int32_t voxel_nm = 0;
  double force_error = 0;  // what the voxel makes of the bur's force, a share (voxel_limit.h)
  // The default law's tick on a device at a rate; without a `run`: not measured there.
  std::function<TimedCase(const DeviceModel& at)> tick;
};
struct JointAxes {
  std::vector<DeviceModel> at_rates;  // the device at each rate, with its Kc there
  std::vector<LawChoice> laws;
  std::vector<std::vector<dvec3>> ways_m;  // of the hand
  std::vector<FrontVoxel> voxels;
  // What is planned without a front: JointPoint::is_default.
  int32_t planned_voxel_nm = 50'000;
  double planned_rate_hz = 1000;
  haptics::LawKind planned_law = haptics::kDefaultLaw;
  double b_n_s_per_m = 6500, grip_n_per_m = 1000;
  int threads = 2;
};
// The axes of any front of this device but what is cut: its own rate and `rates_hz`, every law, a generated hand's
// ways. A rate under its own keeps Kc where that is passive; one over it has a Kc as close to the limit.
JointAxes FrontAxes(const DeviceModel& device, const std::vector<double>& rates_hz,
                    const std::vector<haptics::EstimatorKind>& estimators);
// Every combination, marked. The tick of a law is the default law's plus the difference of the two, measured apart
// from the cut, on which it does not depend.
std::vector<JointPoint> MeasureJointFront(
    const JointAxes& axes, const std::function<void(const char*, size_t, size_t)>& progress = {});

// On the front: no other proved point has no larger error, tick and load, and one of them smaller. A law without
// proof is on no front.
void MarkJointFront(std::vector<JointPoint>* points);
// Felt errors that differ by less are the same. Chosen: a seventieth of the force that a hand tells apart
// (fidelity::kForceShare), so that no tick is doubled for what nobody feels.
inline constexpr double kSameError = 0.001;
// Of the proved points that run on the device and whose 99 % of ticks fit `budget_us` and their own period, by the
// upper ends of their intervals: the cheapest of those whose felt error is the smallest. Null: none fits.
inline constexpr double kNoBudget_us = std::numeric_limits<double>::infinity();
const JointPoint* BestWithin(const std::vector<JointPoint>& points, double budget_us);
// "Of 24 combinations that fit 200 us, …: voxels of 25 um, law lead-maxwell at 1000 Hz, felt 6.9 % off (as planned
// 7.2 %)." Requires: `best` is one of `points`.
std::string WhyBest(const std::vector<JointPoint>& points, const JointPoint& best,
                    double budget_us);
// "Voxels of 25 um in place of 50 cost 12.1 us a tick (11.2 to 13.4) and buy 0.3 points of felt error; …": the next
// halving of the voxel, or where none was measured what a coarser one saves and loses, and the next faster rate. A
// difference with 0 in its interval is not printed.
std::string NextHalvings(const std::vector<JointPoint>& points, const JointPoint& from);

}  // namespace enamel::station::lab
