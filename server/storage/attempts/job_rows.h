#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/attempts/lease_owner.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

struct JobRow {
  Uuid id;
  std::string kind;  // "score"
  Uuid attempt;
  std::string state;  // "queued" | "running" | "done" | "failed" | "cancelled"
  uint32_t tries = 0;
  std::string error;
  std::string cause = "seal";  // "seal" | "reference" | "rescore" | "appeal" | "rubric"
  std::optional<Uuid> batch{};
  double progress = 0;  // 0..1 while running
  // The lease of the run that LeaseJob began: its holder may report progress and the end. Zero if
  // the row was only read.
  Uuid lease{};
  Uuid station{};  // that the attempt was made at; with a lease
};

struct JobFilter {
  std::string state{};  // empty: all
  std::optional<Uuid> batch{};
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

// Field of the kUnavailable that ends a run: somebody cancelled it, or another worker has its job.
// Without this field the database is unreachable at the moment, and the run may continue.
inline constexpr char kLeaseOver[] = "lease";

// The queue of jobs.
class JobRows {
 public:
  JobRows(Transactions& rows, LeaseOwner& owner) : rows_(rows), owner_(owner) {}

  // Takes a job under a lease. A job whose lease ran out is taken again; after 3 tries it is
  // "failed" and shown. Taking a "score" job turns its attempt to "scoring"; its last failure to
  // "failed", or back to "scored" with `problem` set if an earlier run left a score. Any number of
  // workers of any number of servers may ask at once: each gets another job, and never one of an
  // attempt that has a run. A job without a batch is first, because somebody waits for it.
  // With stations in `not_of` it takes only jobs of other stations, and none of a batch.
  Result<std::optional<JobRow>> LeaseJob(UnixMs now_ms, UnixMs lease_ms,
                                         const std::set<Uuid>& not_of = {});
  // Still at it. Errors: kUnavailable with kLeaseOver.
  Status KeepLease(const Uuid& lease, UnixMs until_ms);
  // Of a run that is over already (cancelled, taken over): nothing changes.
  Status FinishJob(const Uuid& lease, bool ok, const std::string& error);
  // Stopped before its end through no fault of its own (shutdown): queued again, the try not
  // counted.
  Status ReturnJob(const Uuid& lease);
  Result<std::vector<JobRow>> Jobs(const std::string& state);
  Result<std::vector<JobRow>> FindJobs(const JobFilter& filter);
  // Queued or running; the attempt is "sealed" again, or "scored" if an earlier run left a score.
  // Its worker hears of it in SetProgress or FinishAttempt. Errors: kNotFound, kConflict (over).
  Status CancelJob(const Uuid& job, const Actor& by);

 private:
  Transactions& rows_;
  LeaseOwner& owner_;
};

// Inside a transaction, for other rows.
Status QueueScoreJob(Db& db, const Uuid& attempt, const std::string& cause,
                     const std::optional<Uuid>& batch = {});
Status CancelRun(Db& db, JobRow job, const Actor& by);
// Queued and running.
Result<std::vector<JobRow>> OpenJobsOf(Db& db, const Uuid& batch);
Result<std::vector<JobRow>> OpenRunsOf(Db& db, const Uuid& attempt);
// kUnavailable unless the run with this lease is under way; locks its job. Zero: no run is meant.
Status MustBeRunning(Db& db, const Uuid& lease);
// The job of this run is done. In the transaction that keeps its result: a worker that died in
// between would be followed by another, with a second result. Zero: no run is meant.
Status FinishRun(Db& db, const Uuid& lease);

}  // namespace enamel::server
