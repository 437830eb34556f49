#pragma once

#include <limits>
#include <string>
#include <vector>

#include "station/lab/suites/findings.h"

// Error against run time, over every figure a law is chosen for, not only steady error. A metric is
// a number read off a row; a law's figure is the worst of the rows that have it. Thread safety:
// pure functions.
namespace enamel::station::lab {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kNever = std::numeric_limits<double>::infinity();  // on no front

struct Metric {
  const char* id;     // of plot files; lower case
  const char* label;  // axis, with its unit
  double floor;       // smaller figures are drawn as this: the axis is logarithmic
  // kNotMeasured: this row does not have it. kNever: never reached.
  double (*of)(const Row&);
};
// Steady error; rise over its floor and release over B/Kc, of the hand that prescribes velocity;
// felt error of a wandering hand of 1 N/mm, pull. The last two are read from Row::extra
// ("felt_error", "pull_n"), which a suite of motions fills. While no row has them they have
// no plot and do not count.
const std::vector<Metric>& FrontMetrics();

// One law with one estimator at one loop rate.
struct LawPoint {
  std::string name;
  double ns_per_tick = 0;
  std::vector<double> figures;  // per metric: the worst of its rows
  std::vector<bool> on_front;   // per metric: no law has a smaller or equal figure for less time
  // No law is at least as good in time and all metrics and better in one.
  bool undominated = false;
  bool lost = false;  // cycles or is unstable in a hand: on no front
  bool is_default = false;
};

// The laws of one device at B = 6.5 N s/mm, from rows of any suite that have a law, an estimator, a
// rate and at least one metric. Rows without nanoseconds take those of the same law's other rows; a
// law without any is left out. A metric that other laws have and this one lacks counts as kNever.
std::vector<LawPoint> LawPointsOf(const std::vector<Row>& rows, const std::string& profile);
// The name LawPointsOf gives to a row's law.
std::string LawPointName(const Row& row);

}  // namespace enamel::station::lab
