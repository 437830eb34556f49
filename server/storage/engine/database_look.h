#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/mutex.h"
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
// the median is within kMaxClockOffMs of the database's clock, this process's times are the
// database's (FollowClock, common/base/unix_time.h), within half the time that the quickest of
// three questions took. Otherwise they are the median's. Of two votes nobody knows which is wrong:
// then the database's counts.
//
// Two primaries. A server that was promoted earlier than another one is not used (PgDbOptions::newest).
// Each row counts its writings, so a second server of the same timeline, or one that was set back, is
// noticed when a row has fewer than before: from then on nothing that was committed can be trusted.
//
// Thread safety: any thread, Beat one.
class DatabaseLook {
 public:
  // Another server whose row is new, and where its station link listens.
  struct Peer {
    Uuid server;
    std::string host;  // numeric
    uint16_t port = 0;
  };
  static constexpr std::chrono::seconds kEvery{2};
  // So long without a Beat that was committed: the database hangs.
  static constexpr std::chrono::seconds kLate{4};
  static constexpr int64_t kMaxClockOffMs = 5000;
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
  // Since the first Beat was begun that has not been committed; 0: the last one was.
  std::chrono::steady_clock::duration unanswered() const;
  // Why the last Beat failed and what to do, where somebody has to mend it (PgRemedyOf); else
  // empty.
  std::string to_mend() const;
  // Only a primary answers that another has replaced.
  bool replaced() const { return replaced_; }
  // The database has lost rows that this server had committed. Stays true.
  bool forked() const { return forked_; }
  // Where this server's station link listens, for its row; every address: the one that the database
  // sees. Before the first Beat.
  void ListenAt(std::string host, uint16_t port) {
    host_ = std::move(host);
    port_ = port;
  }
  // As the last committed Beat found them.
  std::vector<Peer> peers() const;
  const Uuid& server() const { return server_; }
  // The highest timeline of the database that was seen here, or that a peer has seen. Servers of an
  // earlier one are left.
  int64_t timeline() const { return rows_.newest() ? rows_.newest()->load() : 0; }
  void Learn(int64_t timeline);
  // How far this machine's clock is ahead of the database's; 0 where they are one.
  int64_t clock_ahead_ms() const { return clock_ahead_ms_; }
  // How far the median is ahead of the database's clock; 0: less than kMaxClockOffMs, or too few
  // votes.
  int64_t median_ahead_ms() const { return median_ahead_ms_; }
  int clock_votes() const { return clock_votes_; }
  sql::Standby standby() const { return standby_; }
  // Changes take long at the moment: this process or another rewrites the database, or it waits for
  // a missing standby.
  bool ChangesWait() const;

 private:
  Status LookOn(sql::Db& db, bool beat);
  Status WriteRow(sql::Db& db, int64_t theirs_ms);
  Status ReadRows(sql::Db& db, int64_t theirs_ms);

  Transactions& rows_;
  const Rewriter& rewriter_;
  const Uuid server_;
  std::unique_ptr<sql::Db> own_;      // Beat's
  int64_t beats_ = 0, beats_on_ = 0;  // Beat's: its row's count, and the timeline it was read on
  std::string host_;                  // constant since the first Beat
  uint16_t port_ = 0;
  // Since the clock's start; 0: never.
  std::atomic<std::chrono::steady_clock::duration> beaten_{}, asked_{};
  std::atomic<bool> replaced_{false}, forked_{false};
  mutable Mutex mutex_;
  std::vector<Peer> peers_ ENAMEL_GUARDED_BY(mutex_);
  std::string to_mend_ ENAMEL_GUARDED_BY(mutex_);
  std::atomic<int64_t> clock_ahead_ms_{0}, median_ahead_ms_{0};
  std::atomic<int> clock_votes_{1};
  std::atomic<sql::Standby> standby_{sql::Standby::kNotKept};
};

}  // namespace enamel::server
