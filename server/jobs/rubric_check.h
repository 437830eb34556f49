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

// Titles and comments are shown in terminals and tables as they are. Errors: kInvalidInput naming
// the member.
Status CheckRubricWords(const scene::Rubric& rubric);

// A metric that more than one criterion, or more than one gate, asks for: what it costs is then
// taken twice. A warning.
std::vector<std::string> RepeatedMetrics(const scene::Rubric& rubric);

// The exercise whose rubric has this name where `exercise`'s does not; none: no other has it.
Result<std::optional<std::string>> OtherOwnerOfRubric(Store& store, const ExerciseRow& exercise,
                                                      const scene::Rubric& counting,
                                                      const std::string& name);

// What the newest reference itself would get under `rubric`, measured against itself; none without
// a reference. Of a rubric that asks for what was not measured yet the reference is measured again,
// which takes seconds, unless `stored_only`. Errors: the store's, kInvalidInput where it cannot be
// told.
Result<std::optional<scoring::ScoreResult>> ReferenceUnder(Store& store,
                                                           const ExerciseRow& exercise,
                                                           const scene::Rubric& rubric,
                                                           bool stored_only);
// "The reference itself would get 60.0 of 100: Mesial wall 0.0 of 40 …"; empty: full marks.
std::string LostByReference(const scoring::ScoreResult& score);

// What is refused unless somebody insists: another exercise's rubric, and one under which the
// reference itself does not get full marks. Empty: nothing is. Where the reference cannot be read,
// nothing is said of it: it is the reference that is damaged then. Errors: the store's.
Result<std::string> Objections(Store& store, const ExerciseRow& exercise,
                               const scene::Rubric& counting, const scene::Rubric& rubric,
                               bool stored_only);

}  // namespace enamel::server
