#include "server/jobs/worker.h"

#include <algorithm>
#include <exception>

#include "common/base/log_request.h"
#include "common/base/unix_time.h"
#include "server/jobs/score_job.h"
#include "server/ops/yield_to_others.h"

namespace enamel::server {
namespace {

constexpr double kProgressStep = 0.05;
constexpr std::chrono::milliseconds kLookAtQueue{200};
// Stations that may have had their turn before a new round begins.
constexpr size_t kMaxServed = 64;
// Jobs that one thread has begun: each keeps its tooth in memory.
constexpr size_t kMaxBegun = 3;

}  // namespace

Worker::Worker(Store& store, WorkerOptions options) : store_(store), options_(std::move(options)) {}

Worker::~Worker() { Stop(); }

void Worker::Start() {
  for (int i = 0; i < options_.threads; ++i) {
    threads_.emplace_back([this](std::stop_token stop) { Loop(std::move(stop)); });
  }
  // A thread of its own, which does not yield: who computes for a minute would be late.
  heart_ = std::jthread([this](std::stop_token stop) { KeepLeases(std::move(stop)); });
}

void Worker::Stop() {
  for (std::jthread& thread : threads_) thread.request_stop();
  threads_.clear();  // joins
  heart_ = {};       // after the last run has ended
}

void Worker::KeepLeases(std::stop_token stop) {
  while (!stop.stop_requested()) {
    std::vector<Uuid> leases;
    {
      MutexLock lock(mutex_);
      beat_.wait_for(mutex_, stop, options_.heartbeat, [] { return false; });
      for (const auto& [lease, over] : running_) {
        if (!over) leases.push_back(lease);
      }
    }
    for (const Uuid& lease : leases) {
      if (stop.stop_requested()) return;
      const Status kept = store_.jobs.KeepLease(lease, enamel::UnixMs() + options_.lease_ms);
      if (kept.field() != kLeaseOver) continue;
      MutexLock lock(mutex_);
      if (auto at = running_.find(lease); at != running_.end()) at->second = true;
    }
  }
}

bool Worker::IsOver(const Uuid& lease) {
  MutexLock lock(mutex_);
  auto at = running_.find(lease);
  return at != running_.end() && at->second;
}

void Worker::Notify() {
  {
    MutexLock lock(mutex_);
    ++notified_;
  }
  wake_.notify_all();
}

void Worker::Loop(std::stop_token stop) {
  ops::YieldToOthers();
  while (!stop.stop_requested()) {
    // Read before the queue is, so that a Notify in between is not slept through.
    uint64_t seen = Notified();
    if (!RunOne(stop) && !MakeTimeline(stop)) Wait(stop, seen);
  }
}

uint64_t Worker::Notified() {
  MutexLock lock(mutex_);
  return notified_;
}

void Worker::Wait(const std::stop_token& stop, uint64_t seen) {
  MutexLock lock(mutex_);
  wake_.wait_for(mutex_, stop, options_.poll,
                 [&]() ENAMEL_REQUIRES(mutex_) { return notified_ != seen; });
}

Result<std::optional<JobRow>> Worker::TakeInTurn(const std::set<Uuid>& busy) {
  std::set<Uuid> not_of = busy;
  {
    MutexLock lock(mutex_);
    if (served_.size() >= kMaxServed) served_.clear();
    not_of.insert(served_.begin(), served_.end());
  }
  auto job = store_.jobs.LeaseJob(enamel::UnixMs(), options_.lease_ms, not_of);
  const bool all_served = job.ok() && !*job && not_of.size() > busy.size();
  if (all_served) job = store_.jobs.LeaseJob(enamel::UnixMs(), options_.lease_ms, busy);
  MutexLock lock(mutex_);
  if (all_served) served_.clear();
  if (job.ok() && *job) served_.insert((*job)->station);
  return job;
}

bool Worker::RunOne(const std::stop_token& stop, const std::set<Uuid>& busy) {
  auto job = TakeInTurn(busy);
  bool report_queue = false;
  {
    MutexLock lock(mutex_);
    // Logged once when the queue becomes unreadable, because it is read every few seconds.
    report_queue = !job.ok() && queue_ok_;
    queue_ok_ = job.ok();
  }
  if (report_queue) Report({}, job.status());
  if (!job.ok() || !*job) return false;

  const LogAttempt logged((*job)->attempt);
  const Uuid lease = (*job)->lease;
  {
    MutexLock lock(mutex_);
    running_[lease] = false;
  }
  Status status = RunJob(**job, stop, busy);
  {
    MutexLock lock(mutex_);
    running_.erase(lease);
  }
  bool interrupted = status.code() == Code::kUnavailable && stop.stop_requested();
  Status finished = interrupted ? store_.jobs.ReturnJob(lease)
                                : store_.jobs.FinishJob(lease, status.ok(), status.message());
  Report(**job, status.ok() ? finished : status);
  return true;
}

bool Worker::MakeTimeline(const std::stop_token& stop) {
  if (!options_.timelines || stop.stop_requested()) return false;
  {
    MutexLock lock(mutex_);
    if (making_timeline_) return false;
    making_timeline_ = true;
  }
  const bool made = MakeNextTimeline(stop);
  MutexLock lock(mutex_);
  making_timeline_ = false;
  return made;
}

bool Worker::MakeNextTimeline(const std::stop_token& stop) {
  auto attempt = store_.timelines.TakeTimeline();
  // An error of the database is reported when the worker reads the queue.
  if (!attempt.ok() || !*attempt) return false;
  const LogAttempt logged(**attempt);
  auto asked = std::chrono::steady_clock::now(), kept = asked;
  const auto nobody_waits = [&](double) {
    if (stop.stop_requested()) return false;
    // Not at every chunk: the database has better things to do.
    const auto now = std::chrono::steady_clock::now();
    if (now - asked < kLookAtQueue) return true;
    asked = now;
    if (now - kept >= options_.heartbeat) {
      kept = now;
      // At worst another server makes the same.
      (void)store_.timelines.KeepTimeline(**attempt);
    }
    auto queued = store_.jobs.FindJobs({"queued", {}, {}, 1});
    return queued.ok() && queued->empty();
  };
  Status status;
  try {
    status = RunTimelineJob(store_, **attempt, nobody_waits);
  } catch (const std::exception& e) {  // thread's entry: out of memory
    status =
        Status(Code::kInternal, std::string("the timeline ended with an exception: ") + e.what());
    (void)store_.timelines.FailTimeline(**attempt, status.message(), false);
  }
  if (status.code() == Code::kUnavailable) {
    (void)store_.timelines.ReturnTimeline(**attempt);
    return !stop.stop_requested();
  }
  JobRow job;
  job.kind = "timeline";
  job.attempt = **attempt;
  Report(job, status);
  return status.ok();
}

Status Worker::RunJob(const JobRow& job, const std::stop_token& stop, std::set<Uuid> busy) {
  if (job.kind != "score") {
    return Status(Code::kVersion,
                  "job kind \"" + job.kind + "\" is not known to this server: expected \"score\"");
  }
  double told = -kProgressStep;
  busy.insert(job.station);
  auto turn_ends = std::chrono::steady_clock::now() + options_.turn;
  auto progress = [&](double done) {
    if (busy.size() < kMaxBegun && std::chrono::steady_clock::now() >= turn_ends) {
      const bool passed = !stop.stop_requested() && RunOne(stop, busy);
      // Nobody waits: look again, but not at every chunk.
      turn_ends = std::chrono::steady_clock::now() +
                  (passed ? options_.turn : std::min(options_.turn, kLookAtQueue));
    }
    if (done >= told + kProgressStep) {
      told = done;
      // Other trouble than a run that is over is met and reported by the job's own writes.
      if (store_.results.SetProgress(job.lease, done).field() == kLeaseOver) return false;
    }
    return !stop.stop_requested() && !IsOver(job.lease);
  };
  try {
    return RunScoreJob(store_, job.attempt, progress, &references_, job.lease,
                       options_.key ? &*options_.key : nullptr);
  } catch (const std::exception& e) {  // thread's entry: out of memory
    return Status(Code::kInternal, std::string("scoring ended with an exception: ") + e.what());
  }
}

void Worker::Report(const JobRow& job, const Status& status) const {
  if (options_.on_done) options_.on_done(job, status);
}

}  // namespace enamel::server
