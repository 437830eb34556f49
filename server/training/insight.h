#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// A class's results under one assignment: students who have not begun, points lost, outliers. Pure
// functions over plain values; the output is for people and enters no score.
namespace enamel::server {

// A criterion of one score, as schemas/score.md stores it.
struct CriterionPoints {
  std::string name;  // metric
  std::string title;
  std::string unit;
  double value = 0;
  double points = 0;  // after the gates
  double max_points = 0;
  bool judged = true;
  bool operator==(const CriterionPoints&) const = default;
};

// A gate that took points from a score.
struct GateTaken {
  std::string name;  // metric
  std::string title;
  double share = 1;  // of the points that it left
  bool operator==(const GateTaken&) const = default;
};

// One student's work under the assignment.
struct StudentWork {
  uint32_t attempts = 0;        // that were begun; excused and returned ones are none
  std::optional<double> score;  // the result (grade.h); none: nothing counts yet
  double time_s = 0;            // recorded in all those attempts
  bool failed = false;          // of the attempt below: critically
  // Of the attempt that counts; empty: none is scored.
  std::vector<CriterionPoints> criteria;
  std::vector<GateTaken> gates;
};

// The least, the quartiles and the most of some numbers. A quartile that falls between two of them
// is linear in between (type 7 of Hyndman and Fan, "Sample Quantiles in Statistical Packages",
// 1996).
struct Spread {
  uint32_t count = 0;
  double least = 0, lower = 0, median = 0, upper = 0, most = 0;
};
// None where there are no numbers. Requires: finite.
std::optional<Spread> SpreadOf(std::vector<double> values);

// Counts in [0, 10), [10, 20), ... [90, 100] percent.
using Tenths = std::array<uint32_t, 10>;

struct CriterionInsight {
  std::string name, title, unit;
  double max_points = 0;         // the most that it was worth to somebody
  uint32_t judged = 0;           // students
  uint32_t half_lost = 0;        // of those, who lost at least half of its points
  double mean_points = 0;        // of those
  Tenths earned{};               // by the share of its points that they earned
  std::optional<Spread> values;  // of what was measured
};

struct GateInsight {
  std::string name, title;
  uint32_t taken = 0;  // students from whom it took points
};

// Far from the rest of the class.
struct Outlier {
  size_t student = 0;  // place in what was given
  // "score", "time_all_attempts_s" or a criterion's metric, of which time_s is one
  std::string what;
  double value = 0;
  double median = 0;  // of the class
  double z = 0;       // modified z-score, signed
};

struct Insight {
  uint32_t students = 0;
  uint32_t not_started = 0;
  uint32_t waiting = 0;  // begun, and nothing is scored
  uint32_t scored = 0;
  uint32_t failed = 0;  // of those, critically
  std::optional<Spread> scores, times_s;
  Tenths score_tenths{};
  std::vector<CriterionInsight> criteria;  // in the order in which scores have them
  std::vector<GateInsight> gates;          // those that took points from somebody
  std::optional<size_t> commonest;         // of `criteria`: on which most lost at least half
  std::vector<Outlier> outliers;           // by student, the farthest first
};

// A value is an outlier if |z| > 3.5 with z = 0.6745 (x - median) / MAD, MAD the median of |x -
// median| (Iglewicz and Hoaglin, "How to Detect and Handle Outliers", 1993): outliers move neither
// median nor MAD. More than half of a class may share a value, which makes the MAD 0. Then z = (x -
// median) / (1.2533 MeanAD), MeanAD the mean of |x - median| (IBM, Cognos Analytics, "Modified z
// score"). With fewer than 8 values there are no outliers. Times are of students who began. Of
// equally common errors the one that cost more points is listed.
Insight InsightOf(const std::vector<StudentWork>& students);

}  // namespace enamel::server
