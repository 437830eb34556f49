#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "server/agreement/marks.h"

// Where a pass mark lies: standard setting from examiners' marks. Pure functions, any thread.
//
// Borderline regression: whoever marks a piece of work also says what it is worth as a whole, before
// any points are seen. Points are regressed on those ratings; the cut score is what the line gives
// for "borderline".
// Modified Angoff: examiners say, criterion by criterion, how many points a student would earn who is
// just good enough.
//
// Sources: A. Kramer et al., Medical Education 37 (2003) 132, and T. J. Wood, S. M. Humphrey-Murto,
// G. R. Norman, Advances in Health Sciences Education 11 (2006) 115 (borderline regression, and that
// it serves small groups); W. H. Angoff in Educational Measurement, 2nd ed. (1971) 508.
namespace enamel::server {

// The criteria and the work that have a meaning of their own in a file of marks (schemas/marks.md).
inline constexpr std::string_view kTotalCriterion = "total", kRatingCriterion = "rating",
                                  kBorderlineWork = "borderline";

// Global ratings.
enum Rating : uint8_t {
  kClearFail = 1,
  kBorderline = 2,
  kClearPass = 3,
  kGood = 4,
  kExcellent = 5
};

inline constexpr size_t kMinRated = 8, kMinRatings = 3;
// Below it a cut score comes with a warning.
inline constexpr size_t kEnoughRated = 30;

// A piece of work: its points, and the ratings that it got.
struct RatedWork {
  double points = 0;
  std::vector<int> ratings;
};

struct BorderlineCut {
  Agreement cut;  // points; the interval by drawing the work again
  double points_per_rating = 0;
  double explained = 0;  // share of the variance of points, R²
  size_t works = 0, ratings = 0;
  bool few = false;  // fewer than kEnoughRated
};
// Errors: kInvalidInput with the reason: fewer than kMinRated works, fewer than kMinRatings
// different ratings, a rating or points that are none, and where better rated work has no more
// points.
Result<BorderlineCut> BorderlineRegression(const std::vector<RatedWork>& works);

struct AngoffCriterion {
  std::string criterion;
  double mean = 0, spread = 0;  // points; the standard deviation between examiners
  double full_marks = 0;
};
struct AngoffCut {
  Agreement cut;  // percent of the full marks; Student's interval of the examiners' mean
  std::vector<AngoffCriterion> criteria;  // by name
  size_t examiners = 0;
};
// Of the marks for kBorderlineWork, `total` left out. Errors: kInvalidInput: fewer than two
// examiners, one that judged other criteria than the rest, full marks that are missing or differ.
Result<AngoffCut> Angoff(const std::vector<Mark>& marks);

// All that a set of marks says of a pass mark; each figure or why there is none.
struct StandardSetting {
  std::optional<BorderlineCut> borderline;
  std::string why_no_borderline;
  std::optional<AngoffCut> angoff;
  std::string why_no_angoff;
  // Of the people's totals: how far the mean of these examiners decides, at `cut`.
  std::optional<double> cut;  // the one given, else the borderline's, else Angoff's
  Figure phi, phi_at_cut, icc21;
  std::string why_no_agreement;  // SecondMarkerNeeded, in place of all three
  std::vector<std::string> warnings;
};
// Points of rated work are the program's total where it has one (kComputed), else the mean of the
// people's. Errors: kInvalidInput: a mark given twice (CompareMarks), a rating that is not 1 to 5, a
// `cut` that is not 0 to 100.
Result<StandardSetting> SetStandard(const std::vector<Mark>& marks, std::optional<double> cut = {});

// {"borderline": {...} or {"why"}, "angoff": ..., "cut", "phi", "phi_at_cut", "icc_2_1", "warnings"}.
std::string StandardJson(const StandardSetting& standard);

}  // namespace enamel::server
