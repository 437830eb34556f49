#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "server/storage/parts.h"

namespace enamel::test {

// The parts of the store that jobs use, in memory: blobs, attempts with their traces, references,
// the queue. What jobs do not use of them answers kInternal. Fields are open so that a test can arrange and
// spoil them; what is running on other threads must be looked at through the methods. Thread
// safety: methods from any thread.
class MemoryStore final : public server::StationStore,
                          public server::BlobStore,
                          public server::RubricStore,
                          public server::ReferenceStore,
                          public server::AttemptStore,
                          public server::JobStore,
                          public server::TimelineStore {
 public:
  struct Trace {
    Bytes header;
    std::vector<Bytes> chunks;
    trace::Seal seal;
  };
  std::map<Sha256, Bytes> blobs;
  std::map<Uuid, server::AttemptRow> attempts;
  std::map<Uuid, Trace> traces;
  std::map<Uuid, AttemptResult> results;
  std::map<Uuid, server::StationRow> stations;
  std::map<Uuid, server::ReferenceRow> references;  // by exercise: the newest
  std::vector<server::ReferenceRow> older_references;
  std::map<Uuid, server::RubricRow> rubrics;  // by exercise
  std::vector<server::JobRow> jobs;
  std::map<Uuid, server::TimelineRow> timelines;
  std::map<Sha256, Sha256> start_teeth;  // by volume
  std::vector<double> progress;          // everything SetProgress was told
  int failing_puts = 0;                  // this many PutBlob answer kStorage
  double cancel_at = 2;                  // progress at which a run is cancelled; above 1: never

  Result<Sha256> PutBlob(ByteView data) override {
    std::lock_guard lock(mutex_);
    if (failing_puts > 0) {
      --failing_puts;
      return Status(Code::kStorage, "disk full");
    }
    Sha256 hash = HashSha256(data);
    blobs[hash] = Bytes(data.begin(), data.end());
    return hash;
  }
  Result<Sha256> PutAttemptBlob(const Uuid&, ByteView data) override { return PutBlob(data); }
  Result<Bytes> GetBlob(const Sha256& hash) override {
    std::lock_guard lock(mutex_);
    return Find(blobs, hash, "blob");
  }
  bool HasBlob(const Sha256& hash) override {
    std::lock_guard lock(mutex_);
    return blobs.count(hash) != 0;
  }
  Result<server::StationRow> StationById(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    return Find(stations, id, "station");
  }
  Result<server::AttemptRow> AttemptById(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    return Find(attempts, id, "attempt");
  }
  // Looks at exercise, state and page alone.
  Result<std::vector<server::AttemptRow>> Attempts(const server::AttemptFilter& filter) override {
    std::lock_guard lock(mutex_);
    std::vector<server::AttemptRow> out;
    for (auto it = attempts.rbegin(); it != attempts.rend(); ++it) {
      const server::AttemptRow& row = it->second;
      if (filter.exercise && row.exercise != *filter.exercise) continue;
      if (filter.state && row.state != *filter.state) continue;
      if (filter.before && !(row.id < *filter.before)) continue;
      if (out.size() < filter.limit) out.push_back(row);
    }
    return out;
  }
  Result<Bytes> AttemptHeader(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    ENAMEL_ASSIGN_OR_RETURN(auto found, Find(traces, id, "trace"));
    return found.header;
  }
  Result<std::vector<Bytes>> AttemptChunks(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    ++chunk_reads;
    ENAMEL_ASSIGN_OR_RETURN(auto found, Find(traces, id, "trace"));
    return found.chunks;
  }
  Result<std::vector<Bytes>> NewestChunks(const Uuid& id, uint32_t from, uint32_t most) override {
    std::lock_guard lock(mutex_);
    ++newest_reads;
    ENAMEL_ASSIGN_OR_RETURN(auto found, Find(traces, id, "trace"));
    const size_t all = found.chunks.size();
    const size_t first = std::max<size_t>(from, all > most ? all - most : 0);
    if (first >= all) return std::vector<Bytes>();
    return std::vector<Bytes>(found.chunks.begin() + static_cast<std::ptrdiff_t>(first),
                              found.chunks.end());
  }
  Result<trace::Seal> AttemptSeal(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    ENAMEL_ASSIGN_OR_RETURN(auto found, Find(traces, id, "trace"));
    return found.seal;
  }
  Status FinishAttempt(const Uuid& id, const AttemptResult& result, const Uuid& lease) override {
    std::lock_guard lock(mutex_);
    if (Status status = MustBeRunning(lease); !status.ok()) return status;
    results[id] = result;
    attempts[id].state = server::AttemptState::kScored;
    attempts[id].score = result.score;
    attempts[id].problem.clear();
    return Status::Ok();
  }
  Status FailAttempt(const Uuid& id, const std::string& problem, const Uuid& lease) override {
    std::lock_guard lock(mutex_);
    if (attempts.count(id) == 0) return Status(Code::kNotFound, "no attempt");
    if (Status status = MustBeRunning(lease); !status.ok()) return status;
    bool scored = BeforeTheRun(id) == server::AttemptState::kScored;
    attempts[id].state = scored ? server::AttemptState::kScored : server::AttemptState::kFailed;
    attempts[id].problem = problem;
    return Status::Ok();
  }
  Result<AttemptResult> ResultOf(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    return Find(results, id, "result");
  }
  Status SetProgress(const Uuid& lease, double done) override {
    std::unique_lock lock(mutex_);
    progress.push_back(done);
    if (await_beat) beat_.wait_for(lock, std::chrono::minutes(1), [&] { return kept_leases > 0; });
    for (server::JobRow& job : jobs) {
      if (job.lease != lease || done < cancel_at) continue;
      job.state = "cancelled";
      attempts[job.attempt].state = BeforeTheRun(job.attempt);
    }
    return MustBeRunning(lease);
  }
  Result<std::optional<server::ReferenceRow>> ReferenceFor(const Uuid& exercise) override {
    std::lock_guard lock(mutex_);
    auto found = references.find(exercise);
    if (found == references.end()) return std::optional<server::ReferenceRow>();
    return std::optional(found->second);
  }
  Result<std::optional<server::RubricRow>> RubricFor(const Uuid& exercise) override {
    std::lock_guard lock(mutex_);
    auto found = rubrics.find(exercise);
    if (found == rubrics.end()) return std::optional<server::RubricRow>();
    return std::optional(found->second);
  }
  Result<std::optional<server::JobRow>> LeaseJob(server::UnixMs, server::UnixMs) override {
    std::lock_guard lock(mutex_);
    ++leases;
    if (broken_queue_) return Status(Code::kStorage, "database is locked");
    for (server::JobRow& job : jobs) {
      if (job.state != "queued") continue;
      job.state = "running";
      ++job.tries;
      job.lease = Uuid::New();
      return std::optional(job);
    }
    return std::optional<server::JobRow>();
  }
  Status KeepLease(const Uuid& lease, server::UnixMs) override {
    std::lock_guard lock(mutex_);
    ++kept_leases;
    beat_.notify_all();
    for (server::JobRow& job : jobs) {
      if (take_over && job.lease == lease) job.lease = Uuid::New();
    }
    return MustBeRunning(lease);
  }
  Status FinishJob(const Uuid& lease, bool ok, const std::string& error) override {
    std::lock_guard lock(mutex_);
    for (server::JobRow& job : jobs) {
      if (job.lease != lease || job.state != "running") continue;
      job.state = ok ? "done" : job.tries >= 3 ? "failed" : "queued";
      job.error = error;
    }
    return Status::Ok();
  }
  Status ReturnJob(const Uuid& lease) override {
    std::lock_guard lock(mutex_);
    for (server::JobRow& job : jobs) {
      if (job.lease != lease || job.state != "running") continue;
      job.state = "queued";
      --job.tries;
    }
    return Status::Ok();
  }
  Status CancelJob(const Uuid& id, const server::Actor&) override {
    std::lock_guard lock(mutex_);
    for (server::JobRow& job : jobs) {
      if (job.id != id) continue;
      job.state = "cancelled";
      attempts[job.attempt].state = BeforeTheRun(job.attempt);
      return Status::Ok();
    }
    return Status(Code::kNotFound, "no such job");
  }
  // Looks at the state alone.
  Result<std::vector<server::JobRow>> FindJobs(const server::JobFilter& filter) override {
    return Jobs(filter.state);
  }
  Result<std::vector<server::JobRow>> Jobs(const std::string& state) override {
    std::lock_guard lock(mutex_);
    std::vector<server::JobRow> out;
    std::copy_if(jobs.begin(), jobs.end(), std::back_inserter(out),
                 [&](const server::JobRow& j) { return j.state == state; });
    return out;
  }

  Result<std::optional<Uuid>> TakeTimeline() override {
    std::lock_guard lock(mutex_);
    ++timelines_taken;
    for (const auto& [attempt, row] : timelines) {
      if (row.waits) return std::optional(attempt);
    }
    return std::optional<Uuid>();
  }
  Status KeepTimeline(const Uuid&) override { return Status::Ok(); }
  Status ReturnTimeline(const Uuid&) override {
    std::lock_guard lock(mutex_);
    ++timelines_returned;
    return Status::Ok();
  }
  Status PutTimeline(const Uuid& id, const Sha256& content) override {
    std::lock_guard lock(mutex_);
    timelines[id] = {content, false, ""};
    return Status::Ok();
  }
  Status FailTimeline(const Uuid& id, const std::string& problem, bool again) override {
    std::lock_guard lock(mutex_);
    timelines[id].problem = problem;
    timelines[id].waits = again;
    return Status::Ok();
  }
  Result<server::TimelineRow> TimelineOf(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    return Find(timelines, id, "timeline");
  }
  Result<Sha256> StartToothOf(const Sha256& volume) override {
    std::lock_guard lock(mutex_);
    return start_teeth[volume];
  }
  Status PutStartTooth(const Sha256& volume, const Sha256& content) override {
    std::lock_guard lock(mutex_);
    start_teeth[volume] = content;
    return Status::Ok();
  }
  Result<bool> IsStartTooth(const Sha256&) override { return No(); }

  void Queue(const Uuid& attempt) {
    std::lock_guard lock(mutex_);
    jobs.push_back({Uuid::New(), "score", attempt, "queued", 0, "", "seal", 0, {}});
  }
  void SetQueueBroken(bool broken) {
    std::lock_guard lock(mutex_);
    broken_queue_ = broken;
  }

  int chunk_reads = 0, newest_reads = 0;
  int leases = 0, kept_leases = 0;
  bool await_beat = false;  // a run's progress waits until its lease was kept once
  bool take_over = false;   // whoever keeps a lease hears that another worker has the job
  int timelines_taken = 0, timelines_returned = 0;

  // Not used by jobs.
  Result<std::vector<server::EnrolCodeRow>> OpenEnrolCodes(server::UnixMs) override { return No(); }
  Status WithdrawEnrolCode(const Uuid&, const server::Actor&) override { return No(); }
  Result<server::StationRow> RenameStation(const Uuid&, const std::string&, int32_t,
                                           const server::Actor&) override {
    return No();
  }
  Status RevokeStation(const Uuid&, const server::Actor&) override { return No(); }
  Result<std::vector<server::RubricRow>> Rubrics(const Uuid&) override { return No(); }
  Result<server::RubricRow> PublishRubric(const server::RubricRow&, const server::Actor&) override {
    return No();
  }
  Result<Uuid> AddEnrolCode(const Sha256&, server::UnixMs, const server::Actor&) override {
    return No();
  }
  Result<bool> IsEnrolCode(const Sha256&) override { return No(); }
  Result<server::StationRow> EnrolStation(const Sha256&, server::StationRow, const Sha256&,
                                          server::UnixMs) override {
    return No();
  }
  Result<server::StationRow> StationByCredential(const Uuid&, const Sha256&) override {
    return No();
  }
  Status TouchStation(const Uuid&, const std::string&, uint32_t, server::UnixMs) override {
    return No();
  }
  Result<std::vector<server::StationRow>> Stations() override { return No(); }
  Result<std::vector<Uuid>> RevokedStations() override { return No(); }
  Result<std::vector<server::ListedDevice>> ListedDevices() override { return No(); }
  Status ListDevice(const std::string&, const std::string&, const server::Actor&) override {
    return No();
  }
  Status UnlistDevice(const std::string&, const server::Actor&) override { return No(); }
  Result<bool> IsListed(const Hand&) override { return No(); }
  Result<std::vector<server::ResultRow>> ResultsOf(const Uuid&) override { return No(); }
  // Of the same exercise version, as far as they are scored; in the order of their ids.
  Result<std::vector<server::MotionRow>> MotionsBefore(const Uuid& id, uint32_t limit) override {
    std::lock_guard lock(mutex_);
    std::vector<server::MotionRow> out;
    for (auto it = results.rbegin(); it != results.rend(); ++it) {
      if (!(it->first < id) || it->second.motion.IsZero() || out.size() == limit) continue;
      if (attempts[it->first].exercise == attempts[id].exercise) {
        out.push_back({it->first, it->second.motion});
      }
    }
    return out;
  }
  Result<std::optional<server::NearAttempt>> NearestTo(const Uuid& id) override {
    std::lock_guard lock(mutex_);
    return results[id].near;
  }
  Result<std::vector<server::ContradictionRow>> ContradictionsOf(const Uuid&) override {
    return No();
  }
  Result<server::ReferenceRow> AddReference(const Uuid&, const std::string&, bool,
                                            const server::Actor&, const std::string&) override {
    return No();
  }
  Result<server::ReferenceRow> ReferenceById(const Uuid&) override { return No(); }
  Result<std::vector<server::ReferenceRow>> References(const Uuid& exercise) override {
    std::lock_guard lock(mutex_);
    std::vector<server::ReferenceRow> out;
    if (auto newest = references.find(exercise); newest != references.end()) {
      out.push_back(newest->second);
    }
    for (const server::ReferenceRow& row : older_references) {
      if (row.exercise == exercise) out.push_back(row);
    }
    return out;
  }
  Status WithdrawReference(const Uuid&, const server::Actor&) override { return No(); }

 private:
  // Requires: mutex_ is held.
  server::AttemptState BeforeTheRun(const Uuid& attempt) const {
    return results.count(attempt) > 0 ? server::AttemptState::kScored
                                      : server::AttemptState::kSealed;
  }
  // Requires: mutex_ is held.
  Status MustBeRunning(const Uuid& lease) const {
    auto job = std::ranges::find(jobs, lease, &server::JobRow::lease);
    if (lease.IsZero() || (job != jobs.end() && job->state == "running")) return Status::Ok();
    return Status(Code::kUnavailable, "this scoring run was cancelled, or is over",
                  server::kLeaseOver);
  }
  static Status No() { return Status(Code::kInternal, "MemoryStore does not do this"); }
  template <typename Map, typename Key>
  static Result<typename Map::mapped_type> Find(const Map& map, const Key& key, const char* what) {
    auto found = map.find(key);
    if (found == map.end()) return Status(Code::kNotFound, std::string("no such ") + what);
    return found->second;
  }

  std::mutex mutex_;
  std::condition_variable beat_;
  bool broken_queue_ = false;
};

}  // namespace enamel::test
