#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "common/base/result.h"
#include "common/sql/db.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// Where the engine has a clock of its own: from now on this process's times are that one's
// (FollowClock, common/base/unix_time.h), within half the time that the quickest of three questions
// took. Gives how many ms this machine's clock is ahead of it; none: the engine's clock is this
// machine's. Blocks. Errors: the database's.
Result<std::optional<int64_t>> FollowClockOf(sql::Db& db);

// The state of a database on another machine. Thread safety: any thread.
class DatabaseLook {
 public:
  DatabaseLook(Transactions& rows, const Rewriter& rewriter) : rows_(rows), rewriter_(rewriter) {}

  // If the database is on another machine: sets this process's clock to the database's, and updates
  // the values below. Otherwise: nothing. Opening the store has done it once; a program that runs
  // for long calls it every kEvery.
  static constexpr std::chrono::seconds kEvery{10};
  Status Look();

  // How far this machine's clock is ahead of the database's; 0 where they are one.
  int64_t clock_ahead_ms() const { return clock_ahead_ms_; }
  sql::Standby standby() const { return standby_; }
  // Changes take long at the moment: this process or another rewrites the database, or it waits for
  // a missing standby.
  bool ChangesWait() const;

 private:
  Transactions& rows_;
  const Rewriter& rewriter_;
  std::atomic<int64_t> clock_ahead_ms_{0};
  std::atomic<sql::Standby> standby_{sql::Standby::kNotKept};
};

}  // namespace enamel::server
