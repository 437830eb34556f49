#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// A class's results under one assignment: students who have not begun, mistakes, points lost,
// outliers. Pure functions over plain values; the output is for people and enters no score.
namespace enamel::server {

// A criterion of one score, as schemas/score.md stores it.
struct CriterionLost {
  std::string name;  // a group, or a metric of the hand
  std::string group;
  std::string title;
  std::string unit;
  double lost = 0;         // points
  bool to_change = false;  // an examiner asks for a change, or for the work to be done anew
  bool judged = true;      // false: it could not cost anything
  std::optional<double> value = {};  // the hand's
  bool operator==(const CriterionLost&) const = default;
};

// A mistake of one score, likewise.
struct MistakeMade {
  std::string kind, place, group, unit;
  double points = 0;  // that it cost
  double size = 0;    // in `unit`
  std::array<double, 3> at_mm{};
  bool operator==(const MistakeMade&) const = default;
};

// One student's work under the assignment.
struct StudentWork {
  uint32_t attempts = 0;        // that were begun; excused and returned ones are none
  std::optional<double> score;  // the result (grade.h); none: nothing counts yet
  double time_s = 0;            // recorded in all those attempts
  bool failed = false;          // of the attempt below: critically
  // Of the attempt that counts; empty: none is scored.
  std::vector<CriterionLost> criteria;
  std::vector<MistakeMade> mistakes;
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
  std::string name, group, title, unit;
  uint32_t judged = 0;           // students
  uint32_t to_change = 0;        // of those, whose work is not acceptable there
  double mean_lost = 0;          // points, of those
  std::optional<Spread> lost;    // likewise
  std::optional<Spread> values;  // of what was measured
};

// The mistakes of one kind at one place.
struct MistakeInsight {
  std::string kind, place, group, unit;
  uint32_t students = 0;          // who lost at least kWorthTelling by it
  double points = 0;              // that it cost these together
  double size = 0;                // the median of theirs
  std::array<double, 3> at_mm{};  // the middle of theirs
};
// Points. A mistake that costs a student less is not counted.
inline constexpr double kWorthTelling = 0.5;

// Far from the rest of the class.
struct Outlier {
  size_t student = 0;  // place in what was given
  // "score", "time_all_attempts_s" or a metric of the hand, of which time_s is one
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
  std::vector<MistakeInsight> mistakes;    // those first that cost the class most
  std::optional<size_t> commonest;         // of `mistakes`: that most students made
  std::vector<Outlier> outliers;           // by student, the farthest first
};

// A value is an outlier if |z| > 3.5 with z = 0.6745 (x - median) / MAD, MAD the median of |x -
// median| (Iglewicz and Hoaglin, "How to Detect and Handle Outliers", 1993): outliers move neither
// median nor MAD. More than half of a class may share a value, which makes the MAD 0. Then z = (x -
// median) / (1.2533 MeanAD), MeanAD the mean of |x - median| (IBM, Cognos Analytics, "Modified z
// score"). With fewer than 8 values there are no outliers. Times are of students who began. Of
// equally common mistakes the dearest is listed. A student who made a mistake of one kind twice at
// one place lost the points of both by it; its size and place are those of the dearer.
Insight InsightOf(const std::vector<StudentWork>& students);

}  // namespace enamel::server
