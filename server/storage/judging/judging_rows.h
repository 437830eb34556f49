#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/recordings/seal_rows.h"
#include "server/training/types.h"

namespace enamel::server {

// What people decide about an attempt: release, grade, flags. Each of these, and another score,
// raises AttemptRow::revision when it changes something. `revision`: the one that was seen; none:
// whatever it is. Errors also: kConflict with field kStale.
class JudgingRows {
 public:
  JudgingRows(Transactions& rows, SealRows& seals) : rows_(rows), seals_(seals) {}

  // Errors: kConflict (not scored; a blind marking of it is under way; it has kBorderlineScore and nobody has set its score,
  // field "borderline").
  Status ReleaseAttempt(const Uuid& attempt, const Actor& by, std::optional<int32_t> revision = {});
  Status WithdrawRelease(const Uuid& attempt, const Actor& by,
                         std::optional<int32_t> revision = {});
  // Releases every scored attempt under it; how many were not before. Errors: as ReleaseAttempt's,
  // of any of them.
  Result<uint32_t> ReleaseAssignment(const Uuid& id, const Actor& by);
  // None: the computed score counts again; a release of one with kBorderlineScore is withdrawn. Errors: kNotFound, kConflict
  // (not scored).
  Status OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                       const Actor& by, std::optional<int32_t> revision = {});
  // Sets bits of AttemptFlag, with the reason in the audit trail; nothing changes when they are
  // set.
  Status FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                     const Actor& by, std::optional<int32_t> revision = {});
  // Takes kExcused back: the attempt counts as it did before; nothing changes where it is not set.
  Status ClearExcuse(const Uuid& attempt, const Actor& by, std::optional<int32_t> revision = {});
  // Queues a scoring run with the exercise's newest reference. For a quarantined attempt this
  // accepts the committed part: an unsealed one is sealed with it. Errors: kConflict (not sealed, a
  // run is queued, recording removed).
  Status Rescore(const Uuid& attempt, const std::string& cause, const Actor& by);

 private:
  Transactions& rows_;
  SealRows& seals_;
};

// Inside a transaction: queues a run; the attempt must have its whole recording.
Status QueueAgain(Db& db, const Uuid& attempt, const std::string& cause);

}  // namespace enamel::server
