#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "server/agreement/agreement.h"

// Marks of several people (schemas/marks.md), and how well they agree on each criterion. Pure
// functions, any thread.
namespace enamel::server {

inline constexpr size_t kMaxMarksBytes = 4 << 20, kMaxMarkRows = 20'000;
// The marker that is the program.
inline constexpr std::string_view kComputed = "computed";

struct Mark {
  std::string work, criterion, marker;
  double points = 0;
  std::optional<double> full_marks = {};
};

// Rows without a mark are left out. Errors: kInvalidInput with the row.
Result<std::vector<Mark>> ReadMarks(std::string_view csv);

// A figure, or why there is none.
struct Figure {
  std::optional<Agreement> value;
  std::string why;
};

struct PairLimits {
  std::string first, second;  // markers
  std::optional<LimitsOfAgreement> limits;
  std::string why;
};

struct CriterionAgreement {
  std::string criterion;
  std::vector<std::string>
      markers;  // people, in alphabetical order; where there are none, the program
  size_t works = 0, left_out = 0;  // marked by all of them; by some
  // Where fewer than two people marked: why that is too few and what to do, in one sentence. The
  // figures of the people and the limits between them are then empty.
  std::string why;
  // Of the people alone: the program is none of them.
  Figure icc21, icc3k, phi, weighted_kappa, free_kappa;
  std::vector<PairLimits> limits;  // each two markers, the program too
  // The mean of the people's marks against the program's (kComputed), where that is a marker beside
  // them; `computed_works`: marked by all of them and the program.
  bool computed = false;
  size_t computed_works = 0;
  Figure computed_icc21;
};

// By criterion, in alphabetical order. Errors: kInvalidInput when a piece of work was marked twice
// by one marker for one criterion, or there are no marks. What is said of kBorderlineWork
// (standard.h) is left out.
Result<std::vector<CriterionAgreement>> CompareMarks(const std::vector<Mark>& marks);

// Why these people, fewer than two, have no agreement, and what to do: one sentence.
std::string SecondMarkerNeeded(const std::vector<std::string>& people);

// {"criteria": [{"criterion", "markers", "works", "left_out", "icc_2_1", ...}]}; a figure is
// {"value", "low", "high"} or {"value": null, "why"}. Of fewer than two people: "why" in place of
// their figures.
std::string AgreementJson(const std::vector<CriterionAgreement>& criteria);
// One row a figure: criterion, figure, first, second, value, low, high, works, why. Of fewer than
// two people: one row, "agreement", for all of theirs.
std::string AgreementCsv(const std::vector<CriterionAgreement>& criteria);

}  // namespace enamel::server
