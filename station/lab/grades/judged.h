#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scoring/score.h"
#include "station/lab/grades/expected_mistakes.h"
#include "station/lab/grades/sentences.h"

// Whether a grade names the mistake that was made, charges it as one mistake, and says nothing that is not true.
// Thread safety: functions, any thread.
namespace enamel::station::lab {

struct Judged {
  std::vector<ExpectedMistake> expected;  // any of them is right
  std::vector<scoring::Mistake> found;    // the dearest first
  Sentences sentences;
  double sum_error = 0;  // |points of the mistakes - points that regions lost|

  bool IsExpected(const scoring::Mistake& mistake) const;
  // False too where nothing was found.
  bool FirstIsRight() const;
  // Of all mistakes' points, the share of those that are expected. Empty where none is, or less than a point was lost.
  std::optional<double> OwnShare() const;
};

// `attempt`: what was scored, against `r`.
Judged JudgedOf(const Fault& fault, const std::string& exercise, const scoring::AcceptableCut& r,
                const cutting::Volume& attempt, const scoring::ScoreResult& score);

}  // namespace enamel::station::lab
