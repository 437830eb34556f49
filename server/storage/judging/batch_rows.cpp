#include "server/storage/judging/batch_rows.h"

#include <optional>
#include <vector>

#include "common/base/counted.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

// Scoring many attempts again, one job each.
namespace enamel::server {
namespace {

// Has a score and a recording, and no run is waiting or under way.
Result<bool> IsScoredAndIdle(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT 1 FROM attempts a WHERE tenant = ?1 AND id = ?2 AND state = " +
                  Sql(AttemptState::kScored) +
                  " AND trace_blob IS NOT NULL AND NOT EXISTS (SELECT 1 FROM jobs j WHERE j.tenant "
                  "= ?1 AND j.attempt = ?2 AND j.state IN ('queued', 'running'))");
  return q.Bind(attempt).Any();
}

// One, or all, newest first, with their jobs counted by state.
Result<std::vector<BatchRow>> FindBatches(Db& db, const std::optional<Uuid>& id) {
  Query q(db,
          "SELECT b.id, b.title, b.cause, b.cohort, b.queued_ms, "
          "sum(CASE j.state WHEN 'queued' THEN 1 ELSE 0 END), "
          "sum(CASE j.state WHEN 'running' THEN 1 ELSE 0 END), "
          "sum(CASE j.state WHEN 'done' THEN 1 ELSE 0 END), "
          "sum(CASE j.state WHEN 'failed' THEN 1 ELSE 0 END), "
          "sum(CASE j.state WHEN 'cancelled' THEN 1 ELSE 0 END) "
          "FROM job_batches b LEFT JOIN jobs j ON j.tenant = b.tenant AND j.batch = b.id "
          "WHERE b.tenant = ?1 AND (b.id = ?2 OR ?2 = ?3) "
          "GROUP BY b.tenant, b.id, b.title, b.cause, b.cohort, b.queued_ms "
          "ORDER BY b.id DESC LIMIT 100");
  return q.Bind(id.value_or(Uuid{}), Uuid{}).All<BatchRow>();
}

}  // namespace

Result<BatchRow> BatchRows::RescoreTogether(const BatchRow& row, const std::vector<Uuid>& attempts,
                                            uint32_t& left_out, const Actor& by) {
  const Uuid id = Uuid::New();
  Status status = rows_.Write([&](Db& db) -> Status {
    left_out = 0;
    ENAMEL_RETURN_IF_ERROR(Insert(db, "job_batches", "id", id, "title", row.title, "cause",
                                  row.cause, "queued_ms", NowMs(), "cohort", row.cohort));
    for (const Uuid& attempt : attempts) {
      ENAMEL_ASSIGN_OR_RETURN(auto can, IsScoredAndIdle(db, attempt));
      left_out += can ? 0 : 1;
      if (!can) continue;
      ENAMEL_RETURN_IF_ERROR(QueueScoreJob(db, attempt, row.cause, id));
      ENAMEL_RETURN_IF_ERROR(WriteAudit(db, by, "attempt.rescore", attempt.Text(), "{}",
                                        JsonOf({{"cause", row.cause}, {"batch", id.Text()}})));
    }
    // An empty batch would stay in the list forever, with nothing to wait for.
    if (left_out == attempts.size()) {
      return Status(Code::kConflict,
                    "none of " + Counted(attempts.size(), "attempt") +
                        " can be scored again: they were never scored, are waiting for a run "
                        "already, or their recordings were removed");
    }
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return BatchById(id);
}

Result<std::vector<BatchRow>> BatchRows::Batches() {
  return rows_.Read([&](Db& db) { return FindBatches(db, std::nullopt); });
}

Result<BatchRow> BatchRows::BatchById(const Uuid& id) {
  return rows_.Read([&](Db& db) -> Result<BatchRow> {
    ENAMEL_ASSIGN_OR_RETURN(auto found, FindBatches(db, id));
    if (!found.empty()) return found.front();
    return Status(Code::kNotFound, "there is no batch " + id.Text());
  });
}

// Those that are done keep their new scores: each run is an attempt's own.
Status BatchRows::CancelBatch(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto open, OpenJobsOf(db, id));
    if (open.empty()) {
      return Status(Code::kConflict,
                    "batch " + id.Text() + " is over or unknown; nothing to cancel");
    }
    for (const JobRow& row : open) ENAMEL_RETURN_IF_ERROR(CancelRun(db, row, by));
    return Status::Ok();
  });
}

}  // namespace enamel::server
