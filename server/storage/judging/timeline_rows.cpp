#include "server/storage/judging/timeline_rows.h"

#include <optional>
#include <set>
#include <string>

#include "server/storage/engine/query.h"

// Surface timelines, and the teeth they begin with.
namespace enamel::server {
namespace {

// A recording that ends the process each time must not do so forever.
constexpr int64_t kMaxTries = 3;
// A process that died keeps it for this long; a working one renews it more often (KeepTimeline).
constexpr int64_t kLeaseMs = 60'000;

}  // namespace

Status WaitForTimeline(Db& db, const Uuid& attempt) {
  // Scored again after it was given up: the obstacle may be gone.
  return Insert(db, "timelines", "attempt", attempt,
                " ON CONFLICT (tenant, attempt) DO UPDATE SET tries = 0, problem = '', "
                "lease_until_ms = 0 WHERE timelines.content IS NULL");
}

Status DropTimeline(Db& db, const Uuid& attempt, std::set<Sha256>& blobs) {
  Query named(db, "SELECT content FROM timelines WHERE tenant = ?1 AND attempt = ?2");
  if (named.Bind(attempt).Next()) {
    if (Sha256 hash = named.Hash(0); !hash.IsZero()) blobs.insert(hash);
  }
  ENAMEL_RETURN_IF_ERROR(named.status());
  return Query(db, "DELETE FROM timelines WHERE tenant = ?1 AND attempt = ?2").Bind(attempt).Run();
}

Result<std::optional<Uuid>> TimelineRows::TakeTimeline() {
  ENAMEL_RETURN_IF_ERROR(owner_.EndEarlier());
  const int64_t now_ms = NowMs();
  auto next = [&](Db& db, const char* lock) -> Result<std::optional<Uuid>> {
    Query q(db,
            std::string("SELECT attempt FROM timelines WHERE tenant = ?1 AND content IS NULL AND "
                        "tries < ?2 AND lease_until_ms < ?3 ORDER BY CASE WHEN asked_ms = 0 THEN 1 "
                        "ELSE 0 END, asked_ms, attempt DESC LIMIT 1") +
                lock);
    return q.Bind(kMaxTries, now_ms).Maybe<Uuid>();
  };
  // Most calls find nothing: look on a reader first and leave the writer alone.
  auto any = rows_.Read([&](Db& db) { return next(db, ""); });
  if (!any.ok() || !*any) return any;
  std::optional<Uuid> taken;
  ENAMEL_RETURN_IF_ERROR(rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(taken, next(db, db.RowLockOrSkip()));
    if (!taken) return Status::Ok();
    // Counted before the work, not after: a process that dies cannot count.
    Query q(
        db,
        "UPDATE timelines SET tries = tries + 1, owner = ?3, lease_until_ms = ?4 WHERE tenant = "
        "?1 AND attempt = ?2");
    return q.Bind(*taken, owner_.id(), now_ms + kLeaseMs).Run();
  }));
  return taken;
}

Status TimelineRows::KeepTimeline(const Uuid& attempt) {
  return rows_.WriteRow([&](Db& db) -> Status {
    Query q(
        db,
        "UPDATE timelines SET lease_until_ms = ?4 WHERE tenant = ?1 AND attempt = ?2 AND owner = "
        "?3 AND content IS NULL");
    return q.Bind(attempt, owner_.id(), NowMs() + kLeaseMs).Run();
  });
}

Status TimelineRows::ReturnTimeline(const Uuid& attempt) {
  return rows_.WriteRow([&](Db& db) -> Status {
    Query q(
        db,
        "UPDATE timelines SET tries = tries - 1, lease_until_ms = 0 WHERE tenant = ?1 AND attempt "
        "= ?2 AND owner = ?3 AND tries > 0 AND content IS NULL");
    return q.Bind(attempt, owner_.id()).Run();
  });
}

Status TimelineRows::PutTimeline(const Uuid& attempt, const Sha256& content) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db,
            "UPDATE timelines SET content = ?3, problem = '' WHERE tenant = ?1 AND attempt = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, content).Run());
    if (db.Changes() > 0) return blobs_.Hold(db, {content});
    return Status(Code::kConflict,
                  "attempt " + attempt.Text() + " no longer has a recording to be played back");
  });
}

Status TimelineRows::FailTimeline(const Uuid& attempt, const std::string& problem, bool again) {
  // Unless another has taken it meanwhile, or made it.
  return rows_.WriteRow([&](Db& db) -> Status {
    Query q(db,
            "UPDATE timelines SET problem = ?4, lease_until_ms = 0, tries = CASE WHEN ?5 = 1 THEN "
            "tries "
            "ELSE ?6 END WHERE tenant = ?1 AND attempt = ?2 AND owner = ?3 AND content IS NULL");
    return q.Bind(attempt, owner_.id(), problem, again ? 1 : 0, kMaxTries).Run();
  });
}

Result<TimelineRow> TimelineRows::TimelineOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<TimelineRow> {
    Query q(
        db,
        "SELECT content, tries, problem, asked_ms FROM timelines WHERE tenant = ?1 AND attempt = "
        "?2");
    if (!q.Bind(attempt).Next()) {
      ENAMEL_RETURN_IF_ERROR(q.status());
      return Status(Code::kNotFound, "attempt " + attempt.Text() + " has no timeline");
    }
    TimelineRow out;
    out.content = q.Hash(0);
    out.waits = out.content.IsZero() && (q.Int(1) < kMaxTries || q.Text(2).empty());
    out.problem = q.Text(2);
    out.asked = q.Int(3) != 0;
    return out;
  });
}

Result<TimelineRow> TimelineRows::AskForTimeline(const Uuid& attempt) {
  auto row = TimelineOf(attempt);
  if (!row.ok() || !row->waits || row->asked) return row;
  // A write that fails costs only the place in the queue.
  (void)rows_.WriteRow([&](Db& db) -> Status {
    Query q(db,
            "UPDATE timelines SET asked_ms = ?3 WHERE tenant = ?1 AND attempt = ?2 AND asked_ms = "
            "0 AND content IS NULL");
    return q.Bind(attempt, NowMs()).Run();
  });
  return row;
}

Result<Sha256> TimelineRows::StartToothOf(const Sha256& volume) {
  return rows_.Read([&](Db& db) -> Result<Sha256> {
    Query q(db, "SELECT content FROM start_teeth WHERE tenant = ?1 AND volume = ?2");
    return q.Bind(volume).Value<Sha256>();
  });
}

Status TimelineRows::PutStartTooth(const Sha256& volume, const Sha256& content) {
  return rows_.Write([&](Db& db) -> Status {
    return Insert(db, "start_teeth", "volume", volume, "content", content,
                  " ON CONFLICT DO NOTHING");
  });
}

Result<bool> TimelineRows::IsStartTooth(const Sha256& content) {
  return rows_.Read([&](Db& db) -> Result<bool> {
    Query q(db, "SELECT 1 FROM start_teeth WHERE tenant = ?1 AND content = ?2 LIMIT 1");
    return q.Bind(content).Any();
  });
}

}  // namespace enamel::server
