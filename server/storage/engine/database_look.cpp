#include "server/storage/engine/database_look.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "common/base/unix_time.h"
#include "server/storage/engine/pg_database.h"
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

}  // namespace

Status DatabaseLook::WriteRow(sql::Db& db, int64_t theirs_ms) {
  // For this connection's next commit, which is the row's; it may be a new connection. A worker
  // beside the server has the same row: serializable, one of the two could fail.
  ENAMEL_RETURN_IF_ERROR(
      db.Exec("SET synchronous_commit = local; SET default_transaction_isolation = 'read "
              "committed'"));
  // A worker listens nowhere.
  Query q(
      db,
      "INSERT INTO write_probe (tenant, server, at_ms, ahead_ms, beats, host, port) VALUES (?1, "
      "?2, ?3, ?4, 1, coalesce(nullif(?5, ''), host(inet_client_addr()), ''), ?6) ON CONFLICT "
      "(tenant, server) DO UPDATE SET at_ms = ?3, ahead_ms = ?4, beats = write_probe.beats + 1, "
      "host = CASE WHEN ?6 = 0 THEN write_probe.host ELSE excluded.host END, port = CASE WHEN ?6 "
      "= 0 THEN write_probe.port ELSE ?6 END RETURNING beats");
  q.Bind(server_, theirs_ms, clock_ahead_ms_.load(), host_, port_);
  if (!q.Next()) return q.status();
  const int64_t beats = q.Int(0), on = timeline();
  // A standby that takes over may lack the last ones: they were committed on the primary alone.
  if (on == beats_on_ && beats <= beats_) forked_ = true;
  beats_ = beats;
  beats_on_ = on;
  return Status::Ok();
}

Status DatabaseLook::ReadRows(sql::Db& db, int64_t theirs_ms) {
  std::vector<int64_t> votes{0};
  std::vector<Peer> peers;
  Query q(db,
          "SELECT server, ahead_ms, host, port FROM write_probe WHERE tenant = ?1 AND at_ms > ?2");
  for (q.Bind(theirs_ms - kNewMs); q.Next();) {
    votes.push_back(q.Int(1));
    Peer peer{q.Id(0), q.Text(2), static_cast<uint16_t>(q.Int(3))};
    if (peer.server != server_ && !peer.host.empty() && peer.port != 0) {
      peers.push_back(std::move(peer));
    }
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  {
    MutexLock lock(mutex_);
    peers_ = std::move(peers);
  }
  const auto count = static_cast<int>(votes.size());
  const int64_t median = count < kFewestVotes ? 0 : MedianOf(std::move(votes));
  clock_votes_ = count;
  median_ahead_ms_ = std::abs(median) > kMaxClockOffMs ? median : 0;
  return Status::Ok();
}

Status DatabaseLook::LookOn(sql::Db& db, bool beat) {
  ENAMEL_ASSIGN_OR_RETURN(const auto reading, ReadClock(db));
  if (reading) {
    clock_ahead_ms_ = enamel::UnixMs(system_clock::now()) - enamel::UnixMs(reading->Now());
    if (beat) ENAMEL_RETURN_IF_ERROR(WriteRow(db, reading->theirs_ms));
    ENAMEL_RETURN_IF_ERROR(ReadRows(db, reading->theirs_ms));
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
  const auto now = [] { return steady_clock::now().time_since_epoch(); };
  if (beaten_.load() == steady_clock::duration::zero()) beaten_ = now();
  if (asked_.load() == steady_clock::duration::zero()) asked_ = now();
  const auto look = [&]() -> Status {
    if (own_ == nullptr) {
      ENAMEL_ASSIGN_OR_RETURN(own_, rows_.OpenWriter());
    }
    return LookOn(*own_, /*beat=*/true);
  };
  Status looked = look();
  replaced_ = looked.field() == sql::kReplacedField;
  {
    MutexLock lock(mutex_);
    to_mend_ = PgRemedyOf(looked);
  }
  ENAMEL_RETURN_IF_ERROR(looked);
  beaten_ = now();
  asked_ = steady_clock::duration::zero();
  return looked;
}

namespace {
steady_clock::duration Since(steady_clock::duration moment) {
  return moment == steady_clock::duration::zero() ? moment
                                                  : steady_clock::now().time_since_epoch() - moment;
}
}  // namespace

steady_clock::duration DatabaseLook::silence() const { return Since(beaten_); }

steady_clock::duration DatabaseLook::unanswered() const { return Since(asked_); }

std::vector<DatabaseLook::Peer> DatabaseLook::peers() const {
  MutexLock lock(mutex_);
  return peers_;
}

std::string DatabaseLook::to_mend() const {
  MutexLock lock(mutex_);
  return to_mend_;
}

void DatabaseLook::Learn(int64_t timeline) {
  if (!rows_.newest()) return;
  std::atomic<int64_t>& newest = *rows_.newest();
  for (int64_t known = newest; known < timeline;) {
    if (newest.compare_exchange_weak(known, timeline)) break;
  }
}

bool DatabaseLook::ChangesWait() const {
  return rewriter_.running() || rows_.writer().waits() || standby_ == sql::Standby::kMissing;
}

}  // namespace enamel::server
