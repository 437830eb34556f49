#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/training/types.h"

// One result of a person's attempts under an assignment, and of a cohort's results. Pure functions.
// Arithmetic is + and / in a fixed order: the same attempts give the same bits everywhere.
namespace enamel::server {

// An attempt as whoever asks may see it.
struct GradedAttempt {
  Uuid id;
  UnixMs ticketed_ms = 0;
  std::optional<double>
      score{};         // 0..100, the overriding one where there is one; none: not scored yet, or
                       // not to be seen
  bool shown = false;  // the student may see the score
  // It was scored, and is being scored again, or the new score waits for its release.
  bool again = false;
};

struct Grade {
  uint32_t attempts = 0;  // that were made; excused and returned ones are none
  uint32_t counted = 0;   // of those, the scored ones, which the result is chosen or computed from
  std::optional<double> score{};  // none: nothing counts yet
  std::optional<Uuid> attempt{};  // whose score it is, of best and last
  bool shown = false;             // the student may see every score that counts
  // One of them is `again`. A viewer who may not see its score then gets no result, because the
  // others alone may give a different one.
  bool regrading = false;
};

// `best`: the highest, of equal ones the earlier. `last`: of the attempt that was begun last among
// the scored ones. `mean`: sum / n, added up in the order in which they were begun. `median`: the
// middle one; of an even number the mean of the two in the middle.
//   70, 85, 90: best 90, last 90, mean 81.666…, median 85.   70, 85: median 77.5.
Grade GradeOver(Counting counting, std::vector<GradedAttempt> attempts);

// Of a cohort's results under one assignment.
struct GradeSummary {
  uint32_t students = 0;
  uint32_t graded = 0;  // who have a result; the figures below are of those
  std::optional<double> mean{}, median{}, lowest{}, highest{};
};
GradeSummary SummaryOf(const std::vector<Grade>& grades);

}  // namespace enamel::server
