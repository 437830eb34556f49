#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/storage/attempt_store.h"
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
  double progress = 0;         // 0..1 while running
  std::optional<Uuid> batch{};
  // Of the run that LeaseJob has begun: whoever has it may say how the run goes on and ends. Zero
  // where the row was only looked at.
  Uuid lease{};
};

struct JobFilter {
  std::string state{};  // empty: all
  std::optional<Uuid> batch{};
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

// Field of the kUnavailable that says a run is over: it was cancelled, or another worker has its job.
// Without it the database cannot be asked now, and the run may go on.
inline constexpr char kLeaseOver[] = "lease";

// The queue of jobs, and what a run leaves at its attempt.
// A part of Store (store.h), which says what holds for all parts.
class JobStore {
 public:
  virtual ~JobStore() = default;

  // Jobs as leases: a job whose lease ran out is taken again; after 3 tries it is "failed" and
  // shown. Taking a "score" job turns its attempt to "scoring"; its last failure to "failed", or
  // back to "scored" with `problem` set where an earlier run left a score. Any number of workers of
  // any number of servers may ask at once: each gets another job, and never one of an attempt that
  // has a run. A job without a batch goes first, as somebody waits for it.
  virtual Result<std::optional<JobRow>> LeaseJob(UnixMs now_ms, UnixMs lease_ms) = 0;
  // Still at it. Errors: kUnavailable with kLeaseOver.
  virtual Status KeepLease(const Uuid& lease, UnixMs until_ms) = 0;
  // Of a run that is over already (cancelled, taken over): nothing changes.
  virtual Status FinishJob(const Uuid& lease, bool ok, const std::string& error) = 0;
  // Stopped before its end through no fault of its own (shutdown): queued again, the try not
  // counted.
  virtual Status ReturnJob(const Uuid& lease) = 0;
  virtual Result<std::vector<JobRow>> Jobs(const std::string& state) = 0;
  virtual Result<std::vector<JobRow>> FindJobs(const JobFilter& filter) = 0;
  // Queued or running; the attempt is "sealed" again, or "scored" if an earlier run left a score.
  // Its worker hears of it in SetProgress or FinishAttempt. Errors: kNotFound, kConflict (over).
  virtual Status CancelJob(const Uuid& job, const Actor& by) = 0;
  // Of a run's attempt. Errors: kUnavailable with kLeaseOver: stop.
  virtual Status SetProgress(const Uuid& lease, double progress) = 0;
  // `lease`: of the run that made it, whose cause is kept with it and whose job is done with it; zero: none did, the cause is
  // "seal". Errors also: kUnavailable with kLeaseOver.
  virtual Status FinishAttempt(const Uuid& attempt, const AttemptStore::AttemptResult& result,
                               const Uuid& lease) = 0;
  virtual Status FailAttempt(const Uuid& attempt, const std::string& problem,
                             const Uuid& lease) = 0;
};

}  // namespace enamel::server
