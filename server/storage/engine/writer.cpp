#include "server/storage/engine/writer.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace enamel::server {

Writer::Writer(std::unique_ptr<Db> db, bool twice, std::chrono::milliseconds longest_queued)
    : db_(std::move(db)),
      twice_(twice),
      longest_queued_(longest_queued),
      thread_([this] { Loop(); }) {}

Writer::~Writer() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

Status Writer::Run(const Work& work, sql::Isolation isolation) {
  Pending mine{.work = &work, .isolation = isolation};
  return Queue(mine);
}

Status Writer::RunAlone(const std::function<Status(Db& db)>& work) {
  Pending mine{.alone = &work};
  return Queue(mine);
}

Status Writer::Run(sql::Change& change) {
  Pending mine{.change = &change, .isolation = sql::Isolation::kRowLocks};
  return Queue(mine);
}

Status Writer::Queue(Pending& mine) {
  MutexLock lock(mutex_);
  queue_.push_back(&mine);
  if (queue_.size() == 1) wake_.notify_one();
  bool behind = false;
  while (!mine.turn.wait_for(mutex_, longest_queued_, [&] { return mine.done; })) {
    const auto at = std::ranges::find(queue_, &mine);
    // A work that the thread has begun cannot be taken back. The thread's own waits are bounded
    // (SqliteDb::SetBusyWait, SqliteDb::kMaxWait; PgDb::kLongest), except a COMMIT that PostgreSQL
    // holds until a standby has it too. That one may already be on the primary's disk, and must not
    // be reported as failed. Health reports it (Standby::kMissing).
    if (at == queue_.end()) {
      mine.turn.wait(mutex_, [&] { return mine.done; });
      break;
    }
    // Behind what may take long no time counts, nor the round in which that ended.
    if (std::exchange(behind, alone_ || db_->waits()) || behind) continue;
    queue_.erase(at);
    return Status(Code::kUnavailable,
                  "the database is busy; nothing was changed, try again in a few seconds");
  }
  return mine.status;
}

// Commits what waits, in the order it came.
void Writer::Loop() {
  for (;;) {
    {
      MutexLock lock(mutex_);
      // Idle until there is work, or no more to come.
      wake_.wait(mutex_, [&]() ENAMEL_REQUIRES(mutex_) { return stopping_ || !queue_.empty(); });
      if (queue_.empty()) return;
    }
    // Under load, a commit of many costs as much as a commit of one: waiting up to kPace gives
    // fewer and fuller ones.
    std::this_thread::sleep_until(next_commit_);
    std::vector<Pending*> batch;
    {
      MutexLock lock(mutex_);
      // Meanwhile all may have been taken back.
      if (queue_.empty()) continue;
      batch = TakeBatch();
      alone_ = batch.front()->alone != nullptr;
      batch_since_ = batch.front()->since;
    }
    if (batch.size() >= kBusyBatch) next_commit_ = std::chrono::steady_clock::now() + kPace;
    if (batch.front()->alone != nullptr) {
      DoAlone(*batch.front());
    } else {
      Commit(batch);
    }
    MutexLock lock(mutex_);
    alone_ = false;
    batch_since_.reset();
    for (Pending* pending : batch) {
      pending->done = true;
      pending->turn.notify_one();
    }
  }
}

// The oldest work and all that may run with it, in order, up to one that runs alone. That one makes
// a batch of its own.
std::vector<Writer::Pending*> Writer::TakeBatch() {
  std::vector<Pending*> batch;
  if (queue_.front()->alone != nullptr) {
    batch.push_back(queue_.front());
    queue_.pop_front();
    return batch;
  }
  const sql::Isolation isolation = queue_.front()->isolation;
  for (auto at = queue_.begin();
       at != queue_.end() && (*at)->alone == nullptr && batch.size() < kMaxBatch;) {
    if ((*at)->isolation == isolation) {
      batch.push_back(*at);
      at = queue_.erase(at);
    } else {
      ++at;
    }
  }
  return batch;
}

void Writer::DoAlone(Pending& pending) {
  pending.status = (*pending.alone)(*db_);
  db_->Rollback();
  MutexLock lock(mutex_);
  damaged_ = db_->damaged();
}

void Writer::Commit(const std::vector<Pending*>& batch) {
  auto begin = std::chrono::steady_clock::now();
  Status failure = Transact(batch);
  const auto took = std::chrono::steady_clock::now() - begin;
  MutexLock lock(mutex_);
  // Only what the store itself failed at. One that is busy tells nothing, and a refusal of data, or
  // a statement of ours that is wrong, says nothing of whether others can be written: a server must
  // not leave its proxy because of what one party sent it.
  if (failure.ok() || failure.code() == Code::kStorage) last_failure_ = failure;
  damaged_ = db_->damaged();
  for (const Pending* pending : batch) {
    if (pending->status.code() == Code::kStorage) last_failure_ = pending->status;
  }
  if (failure.ok()) {
    const size_t place = counters_.commits % kTimed;
    if (place == timed_s_.size()) timed_s_.push_back(0);
    timed_s_[place] = std::chrono::duration<double>(took).count();
    commits_took_.Add(took);
  }
  ++(failure.ok() ? counters_.commits : counters_.failed_commits);
  counters_.works += failure.ok() ? batch.size() : 0;
}

Status Writer::Transact(const std::vector<Pending*>& batch) {
  auto pause = kFirstPause;
  Status failure = TransactOnce(batch);
  for (int tries = 1; !failure.ok() && db_->must_repeat() && tries < kTries; ++tries) {
    std::uniform_int_distribution<int64_t> part(pause.count() / 2, pause.count());
    std::this_thread::sleep_for(std::chrono::microseconds(part(random_)));
    pause = std::min(2 * pause, kLongestPause);
    failure = TransactOnce(batch);
  }
  return failure;
}

Status Writer::TransactOnce(const std::vector<Pending*>& batch) {
  bool has_failed = false;
  Status failure;
  if (!twice_) failure = TransactTogether(batch, has_failed);
  // One alone that failed has nobody beside it.
  if (twice_ || (has_failed && batch.size() > 1)) failure = TransactApart(batch);
  if (failure.ok()) return failure;
  // The works' own statuses no longer hold: their commit has failed.
  for (Pending* pending : batch) pending->status = failure;
  return failure;
}

Status Writer::TransactTogether(const std::vector<Pending*>& batch, bool& has_failed) {
  Status failure = db_->Begin(batch.front()->isolation);
  std::vector<sql::Change*> changes;
  for (size_t i = 0; failure.ok() && i < batch.size(); ++i) {
    bool keep_anyway = false;
    Status& outcome = batch[i]->status;
    outcome = Status::Ok();
    if (batch[i]->change != nullptr) {
      changes.push_back(batch[i]->change);
      continue;
    }
    outcome = (*batch[i]->work)(*db_, keep_anyway);
    failure = Met();
    if (!failure.ok() || outcome.ok() || keep_anyway) continue;
    db_->Rollback();
    has_failed = true;
    return Status::Ok();
  }
  bool ran = true;
  if (failure.ok()) failure = db_->RunAndCommit(changes, ran);
  if (failure.ok()) return failure;
  db_->Rollback();
  if (ran || db_->must_repeat()) return failure;
  // Which of them does not matter where there are several: they are all run again, each by itself.
  has_failed = true;
  batch.front()->status = failure;
  return Status::Ok();
}

Status Writer::TransactApart(const std::vector<Pending*>& batch) {
  Status failure = db_->Begin(batch.front()->isolation);
  for (size_t i = 0; failure.ok() && i < batch.size(); ++i) {
    failure = RunApart(*batch[i]);
    if (failure.ok()) failure = Met();
  }
  if (failure.ok()) failure = db_->Commit();
  if (!failure.ok()) db_->Rollback();
  return failure;
}

// A transaction that met another's has failed, whatever the work made of that.
Status Writer::Met() const {
  return db_->must_repeat()
             ? Status(Code::kUnavailable, "another server is changing the same data; try again")
             : Status::Ok();
}

std::vector<double> Writer::newest_commits_s() const {
  MutexLock lock(mutex_);
  return timed_s_;
}

Writer::Counters Writer::counters() const {
  MutexLock lock(mutex_);
  return counters_;
}

size_t Writer::queued() const {
  MutexLock lock(mutex_);
  return queue_.size();
}

std::chrono::steady_clock::duration Writer::oldest_wait() const {
  MutexLock lock(mutex_);
  auto oldest = std::chrono::steady_clock::now();
  const auto now = oldest;
  if (batch_since_) oldest = *batch_since_;
  // A batch leaves out what has another isolation: that may be older.
  if (!queue_.empty()) oldest = std::min(oldest, queue_.front()->since);
  return now - oldest;
}

Status Writer::last_failure() const {
  MutexLock lock(mutex_);
  return last_failure_;
}

bool Writer::damaged() const {
  MutexLock lock(mutex_);
  return damaged_;
}

Status Writer::RunIn(const Pending& pending, bool& keep_anyway) {
  return pending.change != nullptr ? pending.change->Run(*db_) : (*pending.work)(*db_, keep_anyway);
}

Status Writer::RunApart(Pending& pending) {
  ENAMEL_RETURN_IF_ERROR(db_->Exec("SAVEPOINT one"));
  // For tests: captured variables of a first run must not show in the second (a database that
  // serves many may end and repeat transactions).
  if (twice_) {
    bool ignored = false;
    (void)RunIn(pending, ignored);
    ENAMEL_RETURN_IF_ERROR(db_->Exec("ROLLBACK TO one"));
  }
  bool keep_anyway = false;
  pending.status = RunIn(pending, keep_anyway);
  if (!pending.status.ok() && !keep_anyway) ENAMEL_RETURN_IF_ERROR(db_->Exec("ROLLBACK TO one"));
  return db_->Exec("RELEASE one");
}

}  // namespace enamel::server
