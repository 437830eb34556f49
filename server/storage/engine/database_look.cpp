#include "server/storage/engine/database_look.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "common/base/unix_time.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

// Rows of servers that have stopped have no vote.
constexpr int64_t kNewMs = 10'000;

struct Reading {
  int64_t theirs_ms;
  steady_clock::duration took;
  steady_clock::time_point at;

  // The answer was made somewhere between question and answer: in the middle, as far as one knows.
  system_clock::time_point Now() const {
    return system_clock::time_point(std::chrono::milliseconds(theirs_ms)) +
           std::chrono::duration_cast<system_clock::duration>(took / 2 +
                                                              (steady_clock::now() - at));
  }
};

// None: the engine's clock is this machine's.
Result<std::optional<Reading>> ReadClock(sql::Db& db) {
  constexpr int kQuestions = 3;
  std::optional<Reading> best;
  for (int i = 0; i < kQuestions; ++i) {
    const auto asked = steady_clock::now();
    ENAMEL_ASSIGN_OR_RETURN(const auto theirs_ms, db.ClockMs());
    if (!theirs_ms) break;
    const auto at = steady_clock::now();
    if (!best || at - asked < best->took) best = Reading{*theirs_ms, at - asked, at};
  }
  return best;
}

// Of two in the middle the one nearer to 0, which is the database's.
int64_t MedianOf(std::vector<int64_t> votes) {
  std::ranges::sort(votes);
  const int64_t low = votes[(votes.size() - 1) / 2], high = votes[votes.size() / 2];
  return std::abs(low) <= std::abs(high) ? low : high;
}

// A new primary begins a new timeline: the first eight digits of the names of its log.
Result<int64_t> TimelineOf(sql::Db& db) {
  sql::Query q(db,
               "SELECT ('x' || substr(pg_walfile_name(pg_current_wal_lsn()), 1, "
               "8))::bit(32)::bigint");
  if (!q.Next()) return q.status();
  return q.Int(0);
}

}  // namespace

Status DatabaseLook::Vote(sql::Db& db, int64_t theirs_ms) {
  std::vector<int64_t> votes{0};
  Query q(db, "SELECT ahead_ms FROM write_probe WHERE tenant = ?1 AND at_ms > ?2");
  for (q.Bind(theirs_ms - kNewMs); q.Next();) votes.push_back(q.Int(0));
  ENAMEL_RETURN_IF_ERROR(q.status());
  const auto count = static_cast<int>(votes.size());
  const int64_t median = count < kFewestVotes ? 0 : MedianOf(std::move(votes));
  clock_votes_ = count;
  median_ahead_ms_ = std::abs(median) > kMostClockOffMs ? median : 0;
  return Status::Ok();
}

Status DatabaseLook::LookOn(sql::Db& db, bool beat) {
  ENAMEL_ASSIGN_OR_RETURN(const auto reading, ReadClock(db));
  if (reading) {
    clock_ahead_ms_ = enamel::UnixMs(system_clock::now()) - enamel::UnixMs(reading->Now());
    if (beat) {
      // For this connection's next commit, which is the row's; it may be a new connection. A worker
      // beside the server has the same row: serializable, one of the two could fail.
      ENAMEL_RETURN_IF_ERROR(
          db.Exec("SET synchronous_commit = local; SET default_transaction_isolation = 'read "
                  "committed'"));
      Query q(db,
              "INSERT INTO write_probe (tenant, server, at_ms, ahead_ms) VALUES (?1, ?2, ?3, ?4) "
              "ON CONFLICT (tenant, server) DO UPDATE SET at_ms = ?3, ahead_ms = ?4");
      ENAMEL_RETURN_IF_ERROR(
          q.Bind(server_).Bind(reading->theirs_ms).Bind(clock_ahead_ms_.load()).Run());
    }
    ENAMEL_RETURN_IF_ERROR(Vote(db, reading->theirs_ms));
    FollowClock(reading->Now() + std::chrono::milliseconds(median_ahead_ms_));
  }
  ENAMEL_ASSIGN_OR_RETURN(standby_, db.StandbyOf());
  return Status::Ok();
}

Status DatabaseLook::Look() {
  if (!rows_.shared()) return Status::Ok();
  return rows_.Read([this](sql::Db& db) { return LookOn(db, /*beat=*/false); });
}

Status DatabaseLook::Beat() {
  if (!rows_.shared()) return Status::Ok();
  if (beaten_.load() == steady_clock::duration::zero()) {
    beaten_ = steady_clock::now().time_since_epoch();
  }
  if (own_ == nullptr) {
    ENAMEL_ASSIGN_OR_RETURN(own_, rows_.OpenWriter());
  }
  ENAMEL_RETURN_IF_ERROR(LookOn(*own_, /*beat=*/true));
  ENAMEL_ASSIGN_OR_RETURN(const int64_t timeline, TimelineOf(*own_));
  replaced_ = timeline < timeline_;
  timeline_ = std::max(timeline, timeline_);
  beaten_ = steady_clock::now().time_since_epoch();
  return Status::Ok();
}

steady_clock::duration DatabaseLook::silence() const {
  const auto beaten = beaten_.load();
  if (beaten == steady_clock::duration::zero()) return beaten;
  return steady_clock::now().time_since_epoch() - beaten;
}

bool DatabaseLook::ChangesWait() const {
  return rewriter_.running() || rows_.writer().waits() || standby_ == sql::Standby::kMissing;
}

}  // namespace enamel::server
