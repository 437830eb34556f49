#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/score.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/actor.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/store.h"
#include "server/storage/teaching/rubric_rows.h"

// What a corrected rubric would change. Scores keep their metrics and measures, so new points need
// no replay, as long as the correction uses no metric that was not measured. BatchRows queues the jobs that then
// replay. Thread safety: functions, any thread; they block for the store.
namespace enamel::server {

// The rubric that counts for an exercise: its newest correction, or the document's own.
Result<scene::Rubric> CountingRubric(StoredBlobs& blobs, RubricRows& rubrics, const Uuid& exercise,
                                     const scene::Rubric& own);

// The score document of an attempt's newest run. Errors: the store's; those of
// scoring::ScoreFromJson.
Result<scoring::ScoreResult> StoredScore(StoredBlobs& blobs, ResultRows& results,
                                         const Uuid& attempt);

struct RegradedAttempt {
  AttemptRow row;
  double before = 0, after = 0;  // computed scores, 0..100; what people set instead is in `row`
  bool failed_before = false, failed_after = false;  // critically
  std::string problem;                               // why there is no `after`; empty: there is one
  // It was measured against other references than those that count now: scored again, it is
  // measured against these, and may change by more than the rubric.
  bool other_references = false;
  // 0 for what is not shown: scores have one decimal, and a document's numbers twelve digits.
  double change() const { return std::abs(after - before) < 0.05 ? 0 : after - before; }
};

// Scored attempts in tenths of the scale: [0, 10), ... [90, 100].
using ScoreHistogram = std::array<uint32_t, 10>;

struct RubricPreview {
  std::vector<RegradedAttempt> attempts;  // by the size of the change, the largest first
  ScoreHistogram before{}, after{};       // of those without a problem
  uint32_t raised = 0, lowered = 0, problems = 0;
  uint32_t other_references = 0;
  // Released, and with other points: scored again, their release is withdrawn.
  uint32_t withdrawn = 0;
  double mean_before = 0, mean_after = 0;
};

// Warnings for people: metrics used twice, and objections that refuse publication unless somebody
// insists (rubric_check.h). Unreadable parts are left out: a preview does without. `quick`: while
// somebody types.
std::vector<std::string> RubricWarnings(Store& store, const ExerciseRow& exercise,
                                        const scene::Rubric& rubric, bool quick);

inline constexpr size_t kMaxPreviewed = 2000;

// The scored attempts that `which` names (its state and page are not read), newest first, at most
// kMaxPreviewed.
Result<std::vector<AttemptRow>> ScoredAttempts(AttemptRows& attempts, AttemptFilter which);

// `rubric` on what was measured of those attempts against the cut that judged them, which are of one
// exercise version. Under another rubric another acceptable cut may be kinder, so that scoring again
// may give more. `counting`: the version's references that count (ReferenceRows::Counting). Errors:
// those of scoring::ValidateRubric.
Result<RubricPreview> PreviewRubric(Store& store, const AttemptFilter& which,
                                    const scene::Rubric& rubric,
                                    const std::vector<ReferenceRow>& counting);

// Checks and stores `rubric` as the next version of the one that counts; its own version is not
// read. `seen`: the version that was corrected. `anyway`: why, although Objections (rubric_check.h)
// speak against it; it stays beside the reason. Errors: those of scoring::ValidateRubric, of
// CheckRubricWords and of RubricRows::PublishRubric; kConflict with field kStale when `seen` is not
// the one that counts, with field kAnyway and the objections.
Result<RubricRow> PublishCorrection(Store& store, const Uuid& exercise, scene::Rubric rubric,
                                    int32_t seen, const std::string& reason,
                                    const std::string& anyway, const Actor& by);

}  // namespace enamel::server
