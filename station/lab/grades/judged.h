#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scoring/score.h"
#include "station/lab/grades/faults.h"

// Whether a grade names the mistake that was made, and charges it as one mistake. Thread safety:
// functions, any thread.
namespace enamel::station::lab {

struct Judged {
  // "wall", "floor", "tilt", "shift", "turn", "taper", "gouge" or "wave": one mistake, which
  // should lose points under its own criteria only. Empty: none of them.
  std::string cause;
  // Of the points lost, the share lost for the cause: by criteria that are about it, and by gates,
  // which no other mistake can have closed. Empty without a cause, for a critical error, and where
  // less than a point was lost.
  std::optional<double> own_share;
  // Where most points were lost: codes of remedies.h, of a critical error its own. Empty where less
  // than half a point was lost.
  std::string said_fault, said_remedy;
  // "wall_mesial_mm 6.0", "gate caries_left_percent 0.8": what cost points, the most first.
  std::vector<std::string> lost_for;
};

Judged JudgedOf(const Fault& fault, const scene::Rubric& rubric, const scoring::ScoreResult& score);

}  // namespace enamel::station::lab
