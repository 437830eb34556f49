#include "common/scoring/board.h"

#include <algorithm>
#include <array>

namespace enamel::scoring {
namespace {

// A critical error whose limit is the source's own. Other errors cite a source for the error, and their limit is chosen
// (common/scene/builtin/critical.cpp). A rubric that has another limit has none that was read.
struct ReadLimit {
  std::string_view error;
  double limit;
  Group category;
};
constexpr ReadLimit kRead[] = {{"pulp_exposed", 0, Group::kTissuePreserved}};

bool Has(const std::vector<CriticalResult>& list, std::string_view error) {
  return std::ranges::find(list, error, &CriticalResult::error) != list.end();
}

// Takes the limit into its category's row.
void Judge(const scene::RubricCritical& asked, const FoundCritical& found, BoardRow& row) {
  const bool critical = Has(found.critical, asked.error);
  row.borderline = row.borderline || Has(found.borderline, asked.error);
  if (row.grade && !critical) return;
  row.grade = critical ? BoardGrade::kCritical : BoardGrade::kSatisfactory;
  row.error = asked.error;
  row.source = asked.source;
}

}  // namespace

std::string_view NameOf(BoardGrade grade) {
  return grade == BoardGrade::kCritical ? "critical" : "satisfactory";
}

std::vector<BoardRow> BoardTable(const scene::Rubric& rubric, const FoundCritical& found) {
  std::vector<BoardRow> out;
  for (const Group category :
       {Group::kOutline, Group::kInternalForm, Group::kMargins, Group::kTissuePreserved}) {
    BoardRow& row = out.emplace_back();
    row.category = category;
    for (const scene::RubricCritical& asked : rubric.critical) {
      const bool read = std::ranges::any_of(kRead, [&](const ReadLimit& limit) {
        return limit.error == asked.error && limit.limit == asked.limit &&
               limit.category == category && !asked.source.starts_with("chosen");
      });
      if (read) Judge(asked, found, row);
    }
  }
  return out;
}

}  // namespace enamel::scoring
