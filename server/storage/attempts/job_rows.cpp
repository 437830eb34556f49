#include "server/storage/attempts/job_rows.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/move_marks.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

// The queue of jobs as leases.
namespace enamel::server {
namespace {

// A recording that ends the process each time must not do so forever.
constexpr int kMaxTries = 3;
constexpr char kSelect[] =
    "SELECT id, kind, attempt, state, tries, error, cause, batch FROM jobs j WHERE tenant = ?1";

// No run of it is under way, and its attempt has none, or the lease of its own ran out.
constexpr char kMayBeTaken[] =
    "((j.state = 'queued' AND NOT EXISTS (SELECT 1 FROM jobs r WHERE r.tenant = j.tenant AND "
    "r.attempt = j.attempt AND r.state = 'running')) OR (j.state = 'running' AND "
    "j.lease_until_ms < ?2))";

// A quarantined attempt stays quarantined: if somebody asked for its run, that has sealed it
// before.
Status BeginRun(Db& db, const Uuid& attempt) {
  Query q(db,
          "UPDATE attempts SET state = ?3, problem = '', problem_field = '', progress = 0 WHERE "
          "tenant = ?1 AND id = "
          "?2 AND state IN (?4, ?5, ?6)");
  q.Bind(attempt, AttemptState::kScoring);
  for (AttemptState from : {AttemptState::kSealed, AttemptState::kScored, AttemptState::kFailed}) {
    q.Bind(from);
  }
  return q.Run();
}

Status SetJob(Db& db, const JobRow& job) {
  Query q(db,
          "UPDATE jobs SET state = ?3, tries = ?4, lease_until_ms = 0, error = ?5, lease = CASE "
          "WHEN ?3 = 'queued' THEN NULL ELSE lease END WHERE tenant = ?1 AND id = ?2");
  return q.Bind(job.id, job.state, job.tries, job.error).Run();
}

Status GiveLease(Db& db, const JobRow& job, UnixMs until_ms, const Uuid& owner) {
  Query q(db,
          "UPDATE jobs SET state = 'running', tries = ?3, lease_until_ms = ?4, lease = ?5, owner = "
          "?6 WHERE tenant = ?1 AND id = ?2");
  return q.Bind(job.id, job.tries, until_ms, job.lease, owner).Run();
}

// A run that did not come to its end: an earlier one's score counts again.
Status EndRun(Db& db, const Uuid& attempt, AttemptState without_score, const std::string& problem) {
  Query q(db, "UPDATE attempts SET state = CASE WHEN score IS NULL THEN " + Sql(without_score) +
                  " ELSE " + Sql(AttemptState::kScored) +
                  " END, problem = ?3, problem_field = '', progress = CASE WHEN score IS NULL THEN "
                  "0 ELSE 1 END WHERE "
                  "tenant = ?1 AND id = ?2 AND state = " +
                  Sql(AttemptState::kScoring));
  return q.Bind(attempt, problem).Run();
}

// The attempt states the reason, not only the job: people look at the attempt.
Status GiveUp(Db& db, JobRow job, const std::string& error) {
  job.state = "failed";
  job.error = error;
  ENAMEL_RETURN_IF_ERROR(SetJob(db, job));
  return EndRun(db, job.attempt, AttemptState::kFailed, error);
}

constexpr char kOfOthers[] =
    " AND j.batch IS NULL AND (SELECT a.station FROM attempts a WHERE a.tenant = j.tenant AND a.id "
    "= j.attempt) NOT IN (";

// The first of those that may be taken. `lock`: what others have locked is left out.
Result<std::optional<JobRow>> NextJob(Db& db, UnixMs now_ms, const std::set<Uuid>& not_of,
                                      const char* lock) {
  std::string others;
  for (size_t i = 0; i < not_of.size(); ++i) {
    others += (i == 0 ? kOfOthers : ", ") + ("?" + std::to_string(3 + i));
  }
  if (!others.empty()) others += ")";
  Query q(db, std::string(kSelect) + " AND " + kMayBeTaken + others +
                  " ORDER BY CASE WHEN batch IS NULL THEN 0 ELSE 1 END, id LIMIT 1" + lock);
  q.Bind(now_ms);
  for (const Uuid& station : not_of) q.Bind(station);
  return q.Maybe<JobRow>();
}

Status LockAttempt(Db& db, const Uuid& attempt) {
  Query q(db, std::string("SELECT 1 FROM attempts WHERE tenant = ?1 AND id = ?2") + db.RowLock());
  (void)q.Bind(attempt).Next();
  return q.status();
}

Result<Uuid> StationOf(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT station FROM attempts WHERE tenant = ?1 AND id = ?2");
  return q.Bind(attempt).Value<Uuid>();
}

// One run of an attempt at a time: two would end in any order. Two jobs of one attempt are two
// rows, which two workers may have locked at the same moment; with the attempt locked the second
// sees what the first has taken.
Result<std::optional<JobRow>> NextJobToTake(Db& db, UnixMs now_ms, const std::set<Uuid>& not_of) {
  for (;;) {
    auto next = NextJob(db, now_ms, not_of, db.RowLockOrSkip());
    if (!next.ok() || !*next) return next;
    ENAMEL_RETURN_IF_ERROR(LockAttempt(db, (*next)->attempt));
    Query still(db, std::string("SELECT 1 FROM jobs j WHERE j.tenant = ?1 AND ") + kMayBeTaken +
                        " AND j.id = ?3");
    if (still.Bind(now_ms, (*next)->id).Next()) return next;
    ENAMEL_RETURN_IF_ERROR(still.status());
  }
}

// Those that have used up their tries are ended on the way, as nobody else would.
Status TakeJob(Db& db, UnixMs now_ms, UnixMs lease_ms, const Uuid& owner,
               const std::set<Uuid>& not_of, std::optional<JobRow>& taken) {
  taken.reset();
  // A worker that opened the school before it was moved would score attempts that now belong
  // elsewhere.
  ENAMEL_ASSIGN_OR_RETURN(const bool moved, HasMoveRow(db, MoveRow::kAway));
  if (moved) return Status::Ok();
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(auto next, NextJobToTake(db, now_ms, not_of));
    if (!next) return Status::Ok();
    JobRow job = *next;
    // A worker that failed called FinishJob; one that died did not, and its lease ran out.
    if (job.tries >= kMaxTries) {
      ENAMEL_RETURN_IF_ERROR(GiveUp(db, job,
                                    "the worker died " + std::to_string(kMaxTries) +
                                        " times on this job" +
                                        (job.error.empty() ? "" : "; before that: " + job.error)));
      continue;
    }
    // Counted before the work, not after: a worker that dies cannot count.
    ++job.tries;
    job.state = "running";
    job.lease = Uuid::New();
    ENAMEL_RETURN_IF_ERROR(GiveLease(db, job, now_ms + lease_ms, owner));
    ENAMEL_RETURN_IF_ERROR(BeginRun(db, job.attempt));
    ENAMEL_ASSIGN_OR_RETURN(job.station, StationOf(db, job.attempt));
    taken = job;
    return Status::Ok();
  }
}

Result<JobRow> FindJob(Db& db, const Uuid& job) {
  Query q(db, std::string(kSelect) + " AND id = ?2");
  return q.Bind(job).One<JobRow>("no job " + job.Text());
}

// The job whose run has this lease, locked; none: that run is over and no longer counts.
Result<std::optional<JobRow>> FindRun(Db& db, const Uuid& lease) {
  Query q(db, std::string(kSelect) + " AND lease = ?2 AND state = 'running'" + db.RowLock());
  return q.Bind(lease).Maybe<JobRow>();
}

Status Requeue(Db& db, JobRow job) {
  job.state = "queued";
  ENAMEL_RETURN_IF_ERROR(SetJob(db, job));
  return EndRun(db, job.attempt, AttemptState::kSealed, job.error);
}

}  // namespace

// The worker notices at its next step (MustBeRunning below).
Status CancelRun(Db& db, JobRow row, const Actor& by) {
  std::string before = JsonOf({{"state", row.state}});
  row.state = "cancelled";
  ENAMEL_RETURN_IF_ERROR(SetJob(db, row));
  ENAMEL_RETURN_IF_ERROR(EndRun(db, row.attempt, AttemptState::kSealed, ""));
  return WriteAudit(db, by, "job.cancel", row.attempt.Text(), before,
                    JsonOf({{"state", row.state}}));
}

namespace {

Result<std::vector<JobRow>> OpenJobs(Db& db, const char* whose, const Uuid& id) {
  Query q(db, std::string(kSelect) + " AND state IN ('queued', 'running') AND " + whose + " = ?2");
  return q.Bind(id).All<JobRow>();
}

}  // namespace

Result<std::vector<JobRow>> OpenJobsOf(Db& db, const Uuid& batch) {
  return OpenJobs(db, "batch", batch);
}

Result<std::vector<JobRow>> OpenRunsOf(Db& db, const Uuid& attempt) {
  return OpenJobs(db, "attempt", attempt);
}

// A run that was cancelled may still come to its end, also after another one was queued.
Status MustBeRunning(Db& db, const Uuid& lease) {
  if (lease.IsZero()) return Status::Ok();
  Query q(db,
          std::string("SELECT state FROM jobs WHERE tenant = ?1 AND lease = ?2") + db.RowLock());
  ENAMEL_ASSIGN_OR_RETURN(const std::string state, q.Bind(lease).Value<std::string>());
  if (state == "running") return Status::Ok();
  return Status(Code::kUnavailable,
                state == "cancelled" ? "this scoring run was cancelled"
                : state.empty()
                    ? "this scoring run is over: its job waits, or another worker has it"
                    : "this scoring run is over: its job is " + state,
                kLeaseOver);
}

Status FinishRun(Db& db, const Uuid& lease) {
  if (lease.IsZero()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto row, FindRun(db, lease));
  if (!row) return Status::Ok();
  row->error.clear();
  row->state = "done";
  return SetJob(db, *row);
}

Status QueueScoreJob(Db& db, const Uuid& attempt, const std::string& cause,
                     const std::optional<Uuid>& batch) {
  return Insert(db, "jobs", "id", Uuid::New(), "kind", "score", "attempt", attempt, "state",
                "queued", "cause", cause, "batch", batch);
}

Result<std::optional<JobRow>> JobRows::LeaseJob(UnixMs now_ms, UnixMs lease_ms,
                                                const std::set<Uuid>& not_of) {
  ENAMEL_RETURN_IF_ERROR(owner_.EndEarlier());
  // Most calls find nothing: look on a reader first and leave the writer alone.
  auto any = rows_.Read([&](Db& db) { return NextJob(db, now_ms, not_of, ""); });
  if (!any.ok() || !*any) return any;
  std::optional<JobRow> taken;
  Status status = rows_.WriteRow(
      [&](Db& db) -> Status { return TakeJob(db, now_ms, lease_ms, owner_.id(), not_of, taken); });
  ENAMEL_RETURN_IF_ERROR(status);
  return taken;
}

Status JobRows::KeepLease(const Uuid& lease, UnixMs until_ms) {
  return rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    Query q(db, "UPDATE jobs SET lease_until_ms = ?3 WHERE tenant = ?1 AND lease = ?2");
    return q.Bind(lease, until_ms).Run();
  });
}

Status JobRows::FinishJob(const Uuid& lease, bool ok, const std::string& error) {
  return rows_.WriteRow([&](Db& db) -> Status {
    if (ok) return FinishRun(db, lease);
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindRun(db, lease));
    if (!row) return Status::Ok();
    if (row->tries >= kMaxTries) return GiveUp(db, *row, error);
    row->error = error;
    return Requeue(db, *row);
  });
}

Status JobRows::ReturnJob(const Uuid& lease) {
  return rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindRun(db, lease));
    if (!row) return Status::Ok();
    // A server that stops has not failed.
    if (row->tries > 0) --row->tries;
    return Requeue(db, *row);
  });
}

Result<std::vector<JobRow>> JobRows::FindJobs(const JobFilter& filter) {
  return rows_.Read([&](Db& db) -> Result<std::vector<JobRow>> {
    Query q(db,
            "SELECT j.id, j.kind, j.attempt, j.state, j.tries, j.error, j.cause, j.batch, CASE "
            "j.state WHEN "
            "'running' THEN a.progress WHEN 'done' THEN 1 ELSE 0 END FROM jobs j JOIN attempts a "
            "ON a.tenant = "
            "j.tenant AND a.id = j.attempt WHERE j.tenant = ?1 AND (?2 = '' OR j.state = ?2) AND "
            "(j.id < ?3 OR ?3 = ?5) AND (j.batch = ?6 OR ?6 = ?5) ORDER BY j.id DESC LIMIT ?4");
    q.Bind(filter.state, filter.before.value_or(Uuid{}), std::clamp<uint32_t>(filter.limit, 1, 200),
           Uuid{}, filter.batch.value_or(Uuid{}));
    return q.All<JobRow>();
  });
}

Result<std::vector<JobRow>> JobRows::Jobs(const std::string& state) {
  JobFilter filter;
  filter.state = state;
  filter.limit = 200;
  return FindJobs(filter);
}

Status JobRows::CancelJob(const Uuid& job, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindJob(db, job));
    if (row.state != "queued" && row.state != "running") {
      return Status(Code::kConflict,
                    "job " + job.Text() + " is " + row.state + "; there is nothing to cancel");
    }
    return CancelRun(db, row, by);
  });
}

}  // namespace enamel::server
