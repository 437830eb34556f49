#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// What people decide and say about an attempt: release, grade, flags, remarks, appeals.
// A part of Store (store.h), which says what holds for all parts.
class JudgingStore {
 public:
  virtual ~JudgingStore() = default;

  // Judging: each of these, and another score, raises AttemptRow::revision when it changes
  // something. `revision`: the one that was seen; none: whatever it is. Errors also: kConflict with
  // field kStale.
  virtual Status ReleaseAttempt(const Uuid& attempt, const Actor& by,
                                std::optional<int32_t> revision = {}) = 0;
  virtual Status WithdrawRelease(const Uuid& attempt, const Actor& by,
                                 std::optional<int32_t> revision = {}) = 0;
  // None: the computed score counts again. Errors: kNotFound, kConflict (not scored).
  virtual Status OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                               const Actor& by, std::optional<int32_t> revision = {}) = 0;
  // Sets bits of AttemptFlag, with the reason in the audit trail; nothing changes when they are
  // set.
  virtual Status FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                             const Actor& by, std::optional<int32_t> revision = {}) = 0;
  // Takes kExcused back: the attempt counts as it did before; nothing changes where it is not set.
  virtual Status ClearExcuse(const Uuid& attempt, const Actor& by,
                             std::optional<int32_t> revision = {}) = 0;
  // Queues a scoring run with the exercise's newest reference. Of a quarantined attempt this
  // accepts what is committed: one that was not sealed is sealed with that. Errors: kConflict (not
  // sealed, a run is queued, recording removed).
  virtual Status Rescore(const Uuid& attempt, const std::string& cause, const Actor& by) = 0;
  // The score of an earlier run (AttemptStore::ResultsOf) counts again, as a run of its own with the
  // cause "restore"; runs that wait or are under way are cancelled. The newest run's: only that. A
  // release of another score is withdrawn as after a run. Errors: kNotFound (no such run), kConflict
  // (all of it is kept only of the newest run and the one before; recording removed).
  virtual Status RestoreResult(const Uuid& attempt, int32_t run, const Actor& by,
                               std::optional<int32_t> revision = {}) = 0;

  // One to the chair gets a remark_id and waits for its station (LiveStore::ChairRemarks).
  virtual Result<AnnotationRow> AddAnnotation(const AnnotationRow& row, const Actor& by) = 0;
  // Text, tick and point of `row` count; `revision` as for drafts (content_store.h).
  virtual Result<AnnotationRow> ReplaceAnnotation(const AnnotationRow& row, const Actor& by) = 0;
  virtual Status DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by) = 0;
  virtual Result<AnnotationRow> AnnotationById(const Uuid& id) = 0;
  // By tick.
  virtual Result<std::vector<AnnotationRow>> AnnotationsOf(const Uuid& attempt) = 0;

  // One per attempt (kConflict), of a released one.
  virtual Status FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by) = 0;
  // With `regrade` as Rescore, in the same transaction. Errors: kNotFound, kConflict (answered).
  virtual Status AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                              const Actor& by) = 0;
  virtual Result<std::optional<AppealRow>> AppealOf(const Uuid& attempt) = 0;
};

}  // namespace enamel::server
