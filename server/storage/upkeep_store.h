#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// What was removed with a person.
struct ErasureReport {
  size_t attempts = 0, references = 0, blobs = 0;
  // False: copies of what was erased may be in unused parts of the database until FinishErasures.
  bool finished = true;
};

// How long things are kept; no rule: for good.
//   "unfinished"  attempts that were never sealed, since their ticket; at least 14 days, as
//                 stations may still upload (schemas/wire/README.md)
//   "recordings"  since sealing: trace, final volume, surface, timeline and force series go, the score stays
//   "attempts"    since sealing (quarantined ones: since their ticket): all of it
// Reference cuts, attempts with a job in the queue, with an appeal that waits for its answer, and
// students' graded work that is neither released nor excused are never touched; quarantined ones,
// being evidence, only by "attempts".
struct RetentionRule {
  std::string what;
  int32_t days = 0;
};

// Attempts a rule applies to now.
struct RetentionReport {
  std::vector<Uuid> unfinished, recordings, attempts;
  size_t blobs = 0;  // removed with them
  size_t held = 0;   // due as well, but kept for an appeal's answer or for their release
};

using sql::Standby;

// How the store does. Counters are since it was opened.
struct StoreHealth {
  bool takes_recordings = true;
  std::string problem;  // why not, and what to do; names no path
  std::string waiting;  // why changes take longer than usual at the moment; empty: they do not
  uint64_t free_bytes = 0, min_free_bytes = 0, database_bytes = 0, log_bytes = 0;
  uint64_t commits = 0, writes = 0, failed_commits = 0;
  double commit_s = 0;  // time spent in commits
  // Of the newest commits, at most 1000: 99 of 100 took at most so long; 0: none is timed.
  size_t timed_commits = 0;
  double commit_p99_s = 0;
  uint64_t chunks = 0, chunk_bytes = 0, sealed = 0;
  // How far this machine's clock is ahead of the database's; 0 where they are one.
  int64_t clock_ahead_ms = 0;
  std::string clock_problem;  // it is too far off, and what to do; empty: it is not
  Standby standby = Standby::kNotKept;
};

// Field of a refusal (kUnavailable): another server of this database erases or applies retention just now.
inline constexpr char kLeaseHeld[] = "lease";

// So far a server's clock may be off before it asks load balancers to leave it alone. Its times are the
// database's all the same; certificates, logs and the requests to an S3 store go by its own.
inline constexpr int64_t kMostClockOffMs = 5000;

// What a server is known by: to stations, in what it signs, and to its key ring.
enum class ServerPart { kStationCertificate, kTicketKey, kKeyRing };

// What keeps the store in order: erasure, retention, health.
// A part of Store (store.h), which says what holds for all parts.
class UpkeepStore {
 public:
  virtual ~UpkeepStore() = default;

  // Erases a person: key, attempts with everything made from them, sessions, memberships, name. The
  // audit trail keeps the id, which nothing leads to any more, and a tombstone stays, so that the
  // person is erased again after a restore. Scores of others that were compared with a reference
  // cut of this person stay. Idempotent after a failure. Errors: kNotFound; kConflict (the person's
  // attempts are references and `with_references` is not set; the only admin who may sign in);
  // kUnavailable (a backup is running).
  virtual Result<ErasureReport> ErasePerson(const Uuid& person, bool with_references,
                                            const Actor& by) = 0;

  virtual Result<std::vector<RetentionRule>> RetentionRules() = 0;
  // Days 0: no rule. Errors: kInvalidInput.
  virtual Status SetRetention(const RetentionRule& rule, const Actor& by) = 0;
  // Removes what the rules say; with `dry_run` only tells. Errors: kUnavailable (a backup is
  // running).
  virtual Result<RetentionReport> ApplyRetention(UnixMs now_ms, bool dry_run, const Actor& by) = 0;
  // Ends what an erasure had to leave (ErasureReport::finished), or a crash; ApplyRetention does it
  // too. Writes wait meanwhile. Nothing to do: nothing. Errors: kUnavailable (a backup is running,
  // or another erasure; somebody reads), kStorage (no room); it is left for the next call.
  virtual Status FinishErasures() = 0;
  // The program is about to end: from now on no other process is waited for, and FinishErasures,
  // also as the end of ErasePerson, leaves the rest to the next start. Any thread.
  virtual void StopWaiting() = 0;

  // Where several servers have their rows in one database, all are known by the same: the first one's
  // fingerprint is kept, and another is refused. Without one: a server that has none yet asks whether it
  // may make its own. Elsewhere nothing is compared. Errors: kConflict (another), kNotFound (it may not).
  virtual Status MatchIdentity(ServerPart part, const std::optional<Sha256>& fingerprint) = 0;

  // Whether other servers may have their rows in the same database.
  virtual bool IsShared() const = 0;
  // Where the database is another machine's: its clock becomes this process's, and Health tells from now on how
  // far this machine's is off, and of standbys. Elsewhere: nothing. Opening the store has done it once; a program
  // that runs for long calls it every kLookEvery.
  static constexpr std::chrono::seconds kLookEvery{10};
  virtual Status LookAtDatabase() = 0;

  // Never fails: trouble is what it tells.
  virtual StoreHealth Health() = 0;
  // After a write that failed: writes something small, so that Health knows whether writing works
  // again. Else nothing.
  virtual Status TryWrite() = 0;
};

}  // namespace enamel::server
