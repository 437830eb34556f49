#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "common/base/histogram.h"
#include "common/base/mutex.h"
#include "server/storage/engine/database.h"

namespace enamel::server {

// This process's one write connection, with group commit. Callers queue their work; a thread of its
// own runs up to kMaxBatch works in one transaction and one fsync, and wakes their owners. If a
// work fails, the batch runs again with a savepoint for each work, and only the failed one is
// rolled back. Not with savepoints from the start: to a remote server the two extra messages of
// each work are most of a chunk's cost. A COMMIT that fails fails the whole batch. Why a thread of
// its own: commits keep their pace when a caller runs at a low priority. Thread safety: any thread.
// Destruction waits for the queue.
class Writer {
 public:
  // A work that was not begun after this time is taken out of the queue and refused, unless it
  // waits for RunAlone or for another process that erases.
  static constexpr std::chrono::milliseconds kLongestQueued{4000};

  // `twice`: runs every work, rolls it back, and runs it again. For tests.
  explicit Writer(std::unique_ptr<Db> db, bool twice = false,
                  std::chrono::milliseconds longest_queued = kLongestQueued);
  ~Writer();

  // Commits the changes of `work` if it returns Ok or sets `keep_anyway` (a refusal that leaves
  // evidence). They are durable when Run returns. A work may be rolled back and run again: another
  // of its batch failed, or a server's database ended conflicting transactions. So it must reset
  // anything it sets outside the database when it starts.
  //
  // `isolation`: kRowLocks for work that comes with every chunk and job, and locks the rows it
  // decides on. Such works have transactions of their own, so that repeating another never repeats
  // them.
  using Work = std::function<Status(Db& db, bool& keep_anyway)>;
  Status Run(const Work& work, sql::Isolation isolation = sql::Isolation::kSerial);
  // One statement, kRowLocks. With a server all of a batch are sent before the first answer.
  Status Run(sql::Change& change);
  // Runs `work` on the thread and outside any transaction, for statements that engines refuse
  // inside one (VACUUM); the queue waits meanwhile.
  Status RunAlone(const std::function<Status(Db& db)>& work);

  // Since the start.
  struct Counters {
    uint64_t commits = 0, works = 0, failed_commits = 0;
  };
  Counters counters() const;
  size_t queued() const;  // works that wait for the thread
  // Since the oldest work that is not done was queued; 0: there is none.
  std::chrono::steady_clock::duration oldest_wait() const;
  // How long commits took, from BEGIN to the end of COMMIT.
  Histogram::Counts commits_took() const { return commits_took_.counts(); }
  // Of the newest: at most kTimed of them, in no order.
  static constexpr size_t kTimed = 1000;
  std::vector<double> newest_commits_s() const;
  // The database was found damaged; stays so.
  bool damaged() const;
  // Why the last transaction could not be written; Ok after one that could. One that found the
  // database busy tells nothing.
  Status last_failure() const;
  // As the connection's.
  bool GoesOnWithChanges() const { return db_->GoesOnWithChanges(); }
  bool waits() const { return db_->waits(); }
  void StopWaiting() { db_->StopWaiting(); }

 private:
  static constexpr size_t kMaxBatch = 256;
  // A batch of this size shows that many write at once: the next commit then waits until more works
  // have gathered. A lone writer never waits.
  static constexpr size_t kBusyBatch = 4;
  static constexpr std::chrono::milliseconds kPace{10};
  // Number of runs of a batch before owners of conflicting transactions get "try again". The pause
  // before each run doubles up to kLongestPause, less a random part: two that conflicted would
  // conflict again.
  static constexpr int kTries = 10;
  static constexpr std::chrono::microseconds kFirstPause{2000}, kLongestPause{100'000};
  struct Pending {
    // One of the three.
    const Work* work = nullptr;
    sql::Change* change = nullptr;
    const std::function<Status(Db& db)>* alone = nullptr;
    sql::Isolation isolation = sql::Isolation::kSerial;
    std::chrono::steady_clock::time_point since = std::chrono::steady_clock::now();
    Status status{};
    bool done = false;
    std::condition_variable_any turn{};  // done
  };
  Status Queue(Pending& mine);  // returns when it is done, or refused
  // The rest of it on the thread.
  void Loop();
  std::vector<Pending*> TakeBatch() ENAMEL_REQUIRES(mutex_);
  void Commit(const std::vector<Pending*>& batch);
  void DoAlone(Pending& pending);
  Status Transact(const std::vector<Pending*>& batch);
  Status TransactOnce(const std::vector<Pending*>& batch);
  // Ok: committed, or refused without a change.
  Status TransactTogether(const std::vector<Pending*>& batch, bool& has_failed);
  Status TransactApart(const std::vector<Pending*>& batch);
  Status RunApart(Pending& pending);
  Status RunIn(const Pending& pending, bool& keep_anyway);
  Status Met() const;

  std::unique_ptr<Db> db_;  // the thread's
  const bool twice_;
  const std::chrono::milliseconds longest_queued_;
  std::chrono::steady_clock::time_point next_commit_{};  // the thread's
  std::minstd_rand random_{std::random_device{}()};      // the thread's
  mutable Mutex mutex_;
  std::condition_variable_any wake_;  // something is queued, or stopping_
  std::deque<Pending*> queue_ ENAMEL_GUARDED_BY(mutex_);
  // When the oldest work of the batch under way was queued.
  std::optional<std::chrono::steady_clock::time_point> batch_since_ ENAMEL_GUARDED_BY(mutex_);
  bool alone_ ENAMEL_GUARDED_BY(mutex_) = false;  // RunAlone is under way
  bool stopping_ ENAMEL_GUARDED_BY(mutex_) = false;
  Status last_failure_ ENAMEL_GUARDED_BY(mutex_);
  bool damaged_ ENAMEL_GUARDED_BY(mutex_) = false;
  Counters counters_ ENAMEL_GUARDED_BY(mutex_);
  Histogram commits_took_;
  // A ring, whose next place is the commits' count.
  std::vector<double> timed_s_ ENAMEL_GUARDED_BY(mutex_);
  std::thread thread_;  // last: uses the rest
};

}  // namespace enamel::server
