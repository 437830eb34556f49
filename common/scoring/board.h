#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/types.h"
#include "common/scoring/critical.h"
#include "common/scoring/metrics.h"
#include "common/scoring/mistakes/mistakes.h"

// A table in the manner of a licensing board, beside the points: each category has the grade of its worst part. Only by
// limits that were read in a published source. Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// Boards also grade what is minor and what needs correction; no limit of these was read.
enum class BoardGrade : uint8_t { kSatisfactory, kCritical };
inline constexpr size_t kBoardGrades = 2;
std::string_view NameOf(BoardGrade grade);  // "satisfactory", "critical"

struct BoardRow {
  Group category = Group::kOutline;
  std::optional<BoardGrade> grade;  // none: the rubric has no limit in this category that was read
  bool borderline = false;          // the measuring does not decide (IsBorderline)
  std::string error;                // the critical error that decides; empty without a grade
  std::string source;               // of its limit

  bool operator==(const BoardRow&) const = default;
};

// The categories that a tooth shows, in their order. `found`: of the rubric.
std::vector<BoardRow> BoardTable(const scene::Rubric& rubric, const FoundCritical& found);

}  // namespace enamel::scoring
