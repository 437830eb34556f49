#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/jobs/reference_cache.h"
#include "server/jobs/score_job.h"
#include "server/jobs/timeline_job.h"

namespace enamel::server {

struct WorkerOptions {
  int threads = 1;
  // How often the worker checks the queue when nobody calls Notify.
  std::chrono::milliseconds poll{200};
  // If a worker is silent for so long, another may take its job, on this server or another one. A
  // worker reports every `heartbeat`. A clock that is set forward by more has a job done twice, of
  // which one counts.
  UnixMs lease_ms = 30'000;
  std::chrono::milliseconds heartbeat{10'000};
  // A job that has taken so long lets one of another station pass that somebody waits for, and again
  // each time it has had as long.
  std::chrono::milliseconds turn{5'000};
  // Signs results (schemas/result.md); none: they stay unsigned.
  std::optional<trace::KeyPair> key{};
  // Makes surface timelines when the queue is empty (timeline_job.h).
  bool timelines = false;
  // Called on a worker's thread after every job, with RunScoreJob's status, and after every
  // timeline, as a job of kind "timeline" without an id. Also with an empty job when the queue
  // cannot be read (once, until it can be again). Must not call Stop.
  std::function<void(const JobRow& job, const Status& status)> on_done;
};

// Runs queued jobs on threads of its own, which yield to others: lease, run, finish. Stations take
// turns, so that one with hundreds of jobs, or with one of hours, costs another a turn: a long job
// waits in the middle while its thread runs another's. A thread that
// finds none makes the newest timeline that is missing, one thread at a time, and puts it off as
// soon as a job is queued: who waits for a score goes first. Progress goes
// to ResultRows::SetProgress at every twentieth. An interrupted job returns to the queue. Thread
// safety: Notify from any thread; Start and Stop from the owner's. `store` must outlive it.
class Worker {
 public:
  explicit Worker(Store& store, WorkerOptions options = {});
  ~Worker();  // Stops.
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void Start();  // Once.
  // Returns when all threads have ended; a running job is interrupted within a chunk's replay or
  // one step of its measuring (about a second). Idempotent.
  void Stop();
  // There may be something in the queue: look now.
  void Notify();

 private:
  void Loop(std::stop_token stop);
  // False when there was nothing to do. `busy`: stations of the jobs that this one interrupts.
  bool RunOne(const std::stop_token& stop, const std::set<Uuid>& busy = {});
  Result<std::optional<JobRow>> TakeInTurn(const std::set<Uuid>& busy);
  bool MakeTimeline(const std::stop_token& stop);  // False when there was none to make.
  bool MakeNextTimeline(const std::stop_token& stop);
  Status RunJob(const JobRow& job, const std::stop_token& stop, std::set<Uuid> busy);
  void KeepLeases(std::stop_token stop);  // until it is stopped
  bool IsOver(const Uuid& lease);
  uint64_t Notified();
  void Wait(const std::stop_token& stop, uint64_t seen);
  void Report(const JobRow& job, const Status& status) const;

  Store& store_;
  const WorkerOptions options_;
  ReferenceCache references_;
  std::vector<std::jthread> threads_;

  Mutex mutex_;
  std::condition_variable_any wake_;
  bool making_timeline_ ENAMEL_GUARDED_BY(mutex_) = false;
  uint64_t notified_ ENAMEL_GUARDED_BY(mutex_) = 0;
  bool queue_ok_ ENAMEL_GUARDED_BY(mutex_) = true;
  std::set<Uuid> served_ ENAMEL_GUARDED_BY(mutex_);         // stations that have had their turn
  std::map<Uuid, bool> running_ ENAMEL_GUARDED_BY(mutex_);  // by lease: it is over, stop
  std::condition_variable_any beat_;                        // never notified but by a stop
  std::jthread heart_;                                      // last: ends before the rest
};

}  // namespace enamel::server
