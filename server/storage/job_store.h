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
};

struct JobFilter {
  std::string state{};  // empty: all
  std::optional<Uuid> batch{};
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

// The queue of jobs, and what a run leaves at its attempt.
// A part of Store (store.h), which says what holds for all parts.
class JobStore {
 public:
  virtual ~JobStore() = default;

  // Jobs as leases: a job whose lease ran out is taken again; after 3 tries it is "failed" and
  // shown. Taking a "score" job turns its attempt to "scoring"; its last failure to "failed", or
  // back to "scored" with `problem` set where an earlier run left a score.
  virtual Result<std::optional<JobRow>> LeaseJob(UnixMs now_ms, UnixMs lease_ms) = 0;
  // Of one that is not running (cancelled, or finished by who took it over): nothing changes.
  virtual Status FinishJob(const Uuid& job, bool ok, const std::string& error) = 0;
  // Stopped before its end through no fault of its own (shutdown): queued again, the try not
  // counted.
  virtual Status ReturnJob(const Uuid& job) = 0;
  virtual Result<std::vector<JobRow>> Jobs(const std::string& state) = 0;
  virtual Result<std::vector<JobRow>> FindJobs(const JobFilter& filter) = 0;
  // Queued or running; the attempt is "sealed" again, or "scored" if an earlier run left a score.
  // Its worker hears of it in SetProgress or FinishAttempt. Errors: kNotFound, kConflict (over).
  virtual Status CancelJob(const Uuid& job, const Actor& by) = 0;
  // Of a run's attempt. kUnavailable: it was cancelled, or is over; stop.
  virtual Status SetProgress(const Uuid& job, double progress) = 0;
  // `job`: the run that made it, whose cause is kept with it; zero: none did, the cause is "seal".
  // Errors also: kUnavailable (that run was cancelled, or is over).
  virtual Status FinishAttempt(const Uuid& attempt, const AttemptStore::AttemptResult& result,
                               const Uuid& job) = 0;
  virtual Status FailAttempt(const Uuid& attempt, const std::string& problem, const Uuid& job) = 0;
};

}  // namespace enamel::server
