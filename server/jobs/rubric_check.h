#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/score.h"
#include "server/storage/store.h"

// Whether a rubric may judge an exercise, beyond what scoring::ValidateRubric sees in it alone.
// Thread safety: functions, any thread; they block for the store.
namespace enamel::server {

// Titles, comments and sources are shown unchanged in terminals and tables. Errors: kInvalidInput naming the
// member.
Status CheckRubricWords(const scene::Rubric& rubric);

// Whether a correction can judge what `counting` judges. Errors: kInvalidInput, field "prices", where
// a kind of region has lost its price: work on it could not be scored.
Status MustKeepRegions(const scene::Rubric& counting, const scene::Rubric& rubric);

// Metrics that more than one criterion uses: each costs points twice. A warning.
std::vector<std::string> RepeatedMetrics(const scene::Rubric& rubric);

// The exercise whose rubric has this name where `exercise`'s does not; none: no other has it.
Result<std::optional<std::string>> OtherOwnerOfRubric(Store& store, const ExerciseRow& exercise,
                                                      const scene::Rubric& counting,
                                                      const std::string& name);

// The score that the newest reference would get under `rubric`, measured against itself; none
// without a reference. If the rubric needs a metric not measured yet, the reference is measured
// again, which takes seconds, unless `stored_only`. Errors: the store's, kInvalidInput if it has no
// score.
Result<std::optional<scoring::ScoreResult>> ReferenceUnder(Store& store,
                                                           const ExerciseRow& exercise,
                                                           const scene::Rubric& rubric,
                                                           bool stored_only);
// "the reference itself would get 90.0 of 100: time_s costs 10.0"; empty: full marks.
std::string LostByReference(const scoring::ScoreResult& score);

// Objections that refuse a rubric unless somebody insists: it is another exercise's, or the
// reference itself does not get full marks under it. Empty: none. An unreadable reference gives no
// objection: then the reference is damaged. Errors: the store's.
Result<std::string> Objections(Store& store, const ExerciseRow& exercise,
                               const scene::Rubric& counting, const scene::Rubric& rubric,
                               bool stored_only);

}  // namespace enamel::server
