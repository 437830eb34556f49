#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/judging/motion_rows.h"
#include "server/training/types.h"

namespace enamel::server {

// What the job leaves: score JSON, final volume blob, deviation by cells (timeline/deviation.h), force
// series).
struct AttemptResult {
  double score = 0;
  bool critical_fail = false;
  Sha256 score_json, final_volume, deviation, series;
  std::optional<Uuid> reference;      // none: the exercise's own target
  double replay_realtime_factor = 0;  // recorded time / replay time: of the machine, not the work
  UnixMs scored_ms = 0;               // 0: now
  Bytes document;                     // signed (schemas/result.md)
  // The score document of the run before, when it gives the same points for the same reasons:
  // then this is no other score, whatever else was measured.
  std::optional<Sha256> same_judgement_as;
  bool shook = false;       // input of FinishAttempt, which sets or clears kShook
  bool borderline = false;  // likewise kBorderlineScore
  // The motion and its nearest neighbour: input of FinishAttempt, which sets or clears
  // kNearAnother, and not returned again (NearestTo). Zero: not measured; earlier findings stay.
  Sha256 motion{};
  scoring::HandFigures hand{};        // with the motion
  std::optional<NearAttempt> near{};  // none: there was none before it
};

// What scoring leaves at an attempt.
class ResultRows {
 public:
  ResultRows(Transactions& rows, Blobs& blobs) : rows_(rows), blobs_(blobs) {}

  // `lease`: of the run that made the result; stores the run's cause and finishes its job. Zero: no
  // run, the cause is "seal". Errors also: kUnavailable with kLeaseOver.
  Status FinishAttempt(const Uuid& attempt, const AttemptResult& result, const Uuid& lease);
  Status FailAttempt(const Uuid& attempt, const Status& problem, const Uuid& lease);
  // Of a run's attempt. Errors: kUnavailable with kLeaseOver: stop.
  Status SetProgress(const Uuid& lease, double progress);
  Result<AttemptResult> ResultOf(const Uuid& attempt);
  // Every run, newest first. Of earlier ones only the score and its reasons are kept.
  Result<std::vector<ResultRow>> ResultsOf(const Uuid& attempt);
  // The score of an earlier run (ResultsOf) counts again, as a run of its own with the
  // cause "restore"; runs that wait or are under way are cancelled. The newest run's: only that. A
  // release of another score is withdrawn as after a run. Errors: kNotFound (no such run),
  // kConflict (all of it is kept only of the newest run and the one before; recording removed).
  Status RestoreResult(const Uuid& attempt, int32_t run, const Actor& by,
                       std::optional<int32_t> revision = {});

 private:
  Transactions& rows_;
  Blobs& blobs_;
};

// Inside a transaction, for other rows.
//
// What the row "attempt.score" of the audit trail tells, or that of an earlier run which counts
// again: score, signed result, why the run was made, where its motion lies.
inline constexpr char kAuditScore[] = "attempt.score", kAuditRestore[] = "attempt.restore";
Result<std::string> ScoredJson(Db& db, const Uuid& attempt, const Sha256& score_json,
                               ByteView document);

}  // namespace enamel::server
