#include "server/storage/attempts/live_rows.h"

#include <algorithm>
#include <string>
#include <vector>

#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

// Remarks on their way to chairs, and connected stations.
namespace enamel::server {
namespace {

// The database's names, in the order of RemarkState.
constexpr std::array kStates{"waiting", "sent", "shown"};

std::string NameOf(RemarkState state) { return kStates[static_cast<size_t>(state)]; }

RemarkState StateOf(const std::string& name) {
  const auto at = std::ranges::find(kStates, name);
  // The database admits no other.
  return static_cast<RemarkState>(at - kStates.begin());
}

// Servers that ended without a word.
Status DeleteSilentServers(Db& db, UnixMs before_ms) {
  Query q(db,
          std::string("SELECT server FROM running_servers WHERE tenant = ?1 AND heard_ms < ?2") +
              db.RowLockOrSkip());
  std::vector<Uuid> silent;
  for (q.Bind(before_ms); q.Next();) silent.push_back(q.Id(0));
  ENAMEL_RETURN_IF_ERROR(q.status());
  for (const Uuid& server : silent) {
    for (const char* sql : {"DELETE FROM station_links WHERE tenant = ?1 AND server = ?2",
                            "DELETE FROM running_servers WHERE tenant = ?1 AND server = ?2"}) {
      ENAMEL_RETURN_IF_ERROR(Query(db, sql).Bind(server).Run());
    }
  }
  return Status::Ok();
}

// Also finds out whether others have deleted what this server said, and keeps them from it until
// the end of the transaction.
Status BeHeard(Db& db, const Uuid& server, UnixMs now_ms, bool anew) {
  if (anew) {
    ENAMEL_RETURN_IF_ERROR(DeleteSilentServers(db, now_ms - LiveRows::kServerSilentMs));
    ENAMEL_RETURN_IF_ERROR(Insert(db, "running_servers", "server", server, "heard_ms", now_ms,
                                  " ON CONFLICT (tenant, server) DO UPDATE SET heard_ms = "
                                  "excluded.heard_ms"));
    return Query(db, "DELETE FROM station_links WHERE tenant = ?1 AND server = ?2")
        .Bind(server)
        .Run();
  }
  Query q(db, "UPDATE running_servers SET heard_ms = ?3 WHERE tenant = ?1 AND server = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(server, now_ms).Run());
  if (db.Changes() > 0) return Status::Ok();
  return {Code::kNotFound, "this server was not heard for so long that others took it for gone"};
}

}  // namespace

Result<std::vector<ChairRemark>> LiveRows::ChairRemarks(UnixMs since_ms) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ChairRemark>> {
    Query q(db,
            "SELECT n.attempt, n.remark_id, n.text, coalesce(p.display_name, ''), n.tick, "
            "n.created_ms, n.remark_state, n.shown_ms FROM annotations n JOIN attempts a ON "
            "a.tenant = n.tenant AND a.id = n.attempt LEFT JOIN people p ON p.tenant = n.tenant "
            "AND p.id = n.author WHERE n.tenant = ?1 AND n.remark_id IS NOT NULL AND n.created_ms "
            ">= ?2 AND a.state IN (" +
                Sql(AttemptState::kTicketed) + ", " + Sql(AttemptState::kRecording) +
                ") ORDER BY n.attempt, n.remark_id");
    std::vector<ChairRemark> out;
    for (q.Bind(since_ms); q.Next();) {
      out.push_back({q.Id(0), static_cast<uint64_t>(q.Int(1)), q.Text(2), q.Text(3),
                     static_cast<uint64_t>(q.Int(4)), q.Int(5), StateOf(q.Text(6)), q.Int(7)});
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    return out;
  });
}

Status LiveRows::MoveRemarks(const std::vector<ChairRemark>& moved) {
  return rows_.WriteRow([&](Db& db) -> Status {
    for (const ChairRemark& remark : moved) {
      // Shown is the last; sent follows waiting alone.
      Query q(db,
              "UPDATE annotations SET remark_state = ?4, shown_ms = ?5 WHERE tenant = ?1 AND "
              "attempt = ?2 AND remark_id = ?3 AND remark_state <> 'shown' AND remark_state <> ?4");
      ENAMEL_RETURN_IF_ERROR(
          q.Bind(remark.attempt, remark.id, NameOf(remark.state), remark.shown_ms).Run());
    }
    return Status::Ok();
  });
}

Status LiveRows::KeepLinks(const std::vector<StationLink>& come, const std::vector<Uuid>& gone,
                           bool anew) {
  return rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(BeHeard(db, owner_.id(), NowMs(), anew));
    for (const StationLink& link : come) {
      ENAMEL_RETURN_IF_ERROR(Insert(db, "station_links", "server", owner_.id(), "station",
                                    link.station, "shows_remarks", link.shows_remarks,
                                    " ON CONFLICT (tenant, server, station) DO UPDATE SET "
                                    "shows_remarks = excluded.shows_remarks"));
    }
    for (const Uuid& station : gone) {
      Query q(db, "DELETE FROM station_links WHERE tenant = ?1 AND server = ?2 AND station = ?3");
      ENAMEL_RETURN_IF_ERROR(q.Bind(owner_.id(), station).Run());
    }
    return Status::Ok();
  });
}

Result<size_t> LiveRows::OtherServers() {
  return rows_.Read([&](Db& db) -> Result<size_t> {
    Query q(db,
            "SELECT count(*) FROM running_servers WHERE tenant = ?1 AND server <> ?2 AND heard_ms "
            ">= ?3");
    const bool told = q.Bind(owner_.id(), NowMs() - LiveRows::kServerSilentMs).Next();
    if (!told) return q.status();
    return static_cast<size_t>(q.Int(0));
  });
}

Result<std::vector<StationLink>> LiveRows::LinksElsewhere() {
  return rows_.Read([&](Db& db) -> Result<std::vector<StationLink>> {
    Query q(db,
            "SELECT l.station, max(l.shows_remarks) FROM station_links l JOIN running_servers s ON "
            "s.tenant = l.tenant AND s.server = l.server WHERE l.tenant = ?1 AND l.server <> ?2 "
            "AND s.heard_ms >= ?3 GROUP BY l.station");
    return q.Bind(owner_.id(), NowMs() - LiveRows::kServerSilentMs).All<StationLink>();
  });
}

}  // namespace enamel::server
