#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// The state of a database on another machine, and this process's clock. A server writes a row of
// its own every kEvery (Beat), so that a database that hangs is noticed even when nobody writes.
//
// The clock. The database and each server whose row is new have one vote each on the time. While
// the median is within kMostClockOffMs of the database's clock, this process's times are the
// database's (FollowClock, common/base/unix_time.h), within half the time that the quickest of
// three questions took. Otherwise they are the median's. Of two votes nobody knows which is wrong:
// then the database's counts.
//
// Thread safety: any thread, Beat one.
class DatabaseLook {
 public:
  static constexpr std::chrono::seconds kEvery{2};
  // So long without a Beat that was committed: the database hangs.
  static constexpr std::chrono::seconds kLate{4};
  static constexpr int64_t kMostClockOffMs = 5000;
  static constexpr int kFewestVotes = 3;

  // `server`: whose rows are its own.
  DatabaseLook(Transactions& rows, const Rewriter& rewriter, const Uuid& server)
      : rows_(rows), rewriter_(rewriter), server_(server) {}

  // If the database is on another machine: sets this process's clock, and updates the values below.
  // Otherwise: nothing. Opening the store has done it once.
  Status Look();
  // The same on a connection of its own, which also commits this server's row, without waiting for a
  // standby: a missing one is another matter. Blocks for some seconds at most. For a program that
  // runs for long, every kEvery.
  Status Beat();

  // The last committed Beat is longer ago than kLate. Never where nobody calls Beat. Does not wait.
  bool hangs() const { return silence() > kLate; }
  // Since the last committed Beat; 0 where nobody calls it.
  std::chrono::steady_clock::duration silence() const;
  // The last Beat was answered by a primary that another has replaced: its timeline is an earlier
  // one than was seen before.
  bool replaced() const { return replaced_; }
  // How far this machine's clock is ahead of the database's; 0 where they are one.
  int64_t clock_ahead_ms() const { return clock_ahead_ms_; }
  // How far the median is ahead of the database's clock; 0: less than kMostClockOffMs, or too few
  // votes.
  int64_t median_ahead_ms() const { return median_ahead_ms_; }
  int clock_votes() const { return clock_votes_; }
  sql::Standby standby() const { return standby_; }
  // Changes take long at the moment: this process or another rewrites the database, or it waits for
  // a missing standby.
  bool ChangesWait() const;

 private:
  Status LookOn(sql::Db& db, bool beat);
  Status Vote(sql::Db& db, int64_t theirs_ms);

  Transactions& rows_;
  const Rewriter& rewriter_;
  const Uuid server_;
  std::unique_ptr<sql::Db> own_;                               // Beat's
  int64_t timeline_ = 0;                                       // Beat's: the highest seen
  std::atomic<std::chrono::steady_clock::duration> beaten_{};  // since the clock's start; 0: never
  std::atomic<bool> replaced_{false};
  std::atomic<int64_t> clock_ahead_ms_{0}, median_ahead_ms_{0};
  std::atomic<int> clock_votes_{1};
  std::atomic<sql::Standby> standby_{sql::Standby::kNotKept};
};

}  // namespace enamel::server
