#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/scoring/score.h"
#include "server/agreement/marks.h"
#include "server/storage/store.h"

// The work of an assignment that examiners mark, and the program as one more marker of it. Thread
// safety: functions, any thread; they block for the store.
namespace enamel::server {

struct ScoredWork {
  Uuid attempt;
  scoring::ScoreResult score;
};

// Errors: kNotFound (no scored attempt under it), those of the store.
Result<std::vector<ScoredWork>> ScoredUnder(Store& store, const Uuid& assignment);

// What people mark on the tooth: the criteria of a score without those of the hand.
std::vector<scoring::CriterionResult> MarkedGroups(const scoring::ScoreResult& score);

// The program's marks (kComputed): each of MarkedGroups by its title, full marks less what it lost
// and never below 0, and kTotalCriterion.
std::vector<Mark> ComputedMarks(const std::vector<ScoredWork>& works);

}  // namespace enamel::server
