#include "server/storage/sqlite_impl.h"

// Enrolment codes and stations.
namespace enamel::server::sqlite {
namespace {

StationRow StationOf(const Query& q) {
  StationRow out;
  out.id = q.Id(0);
  out.name = q.Text(1);
  out.public_key = q.Blob(2);
  out.revoked = q.Int(3) != 0;
  out.enrolled_ms = q.Int(4);
  out.last_seen_ms = q.Int(5);
  return out;
}

Result<StationRow> OneStation(Query& q, const Uuid& id) {
  if (q.Next()) return StationOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no station " + id.Text());
}

}  // namespace

Status SqliteStore::AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms, const Actor& by) {
  return Write([&](Db& db) -> Status {
    Query q(db, "INSERT INTO enrol_codes (tenant, code_hash, expires_ms) VALUES (?1, ?2, ?3)");
    ENAMEL_RETURN_IF_ERROR(q.Bind(code_hash).Bind(expires_ms).Run());
    return WriteAudit(db, by, "station.code", "", "{}",
                      JsonOf({{"expires_ms", std::to_string(expires_ms)}}));
  });
}

Result<StationRow> SqliteStore::EnrolStation(const Sha256& code_hash, StationRow station,
                                             const Sha256& credential_hash, UnixMs now_ms) {
  if (station.id.IsZero()) station.id = Uuid::New();
  station.enrolled_ms = station.last_seen_ms = now_ms;
  Status status = Write([&](Db& db) -> Status {
    Query use(db,
              "UPDATE enrol_codes SET used_ms = ?3 WHERE tenant = ?1 AND code_hash = ?2 AND "
              "used_ms IS NULL AND expires_ms >= ?3");
    ENAMEL_RETURN_IF_ERROR(use.Bind(code_hash).Bind(now_ms).Run());
    if (db.Changes() == 0) {
      return Status(Code::kUnauthenticated,
                    "the enrolment code is unknown, used or expired; ask an admin for a new one");
    }
    Query q(db,
            "INSERT INTO stations (tenant, id, name, public_key, credential_hash, enrolled_ms, "
            "last_seen_ms) "
            "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6)");
    q.Bind(station.id)
        .Bind(station.name)
        .Bind(Bytes(station.public_key))
        .Bind(credential_hash)
        .Bind(now_ms);
    ENAMEL_RETURN_IF_ERROR(q.Run());
    return WriteAudit(db, Actor{{}, "station " + station.name}, "station.enrol", station.id.Text(),
                      "{}", JsonOf({{"name", station.name}}));
  });
  if (!status.ok()) return status;
  return station;
}

Result<StationRow> SqliteStore::StationByCredential(const Uuid& id, const Sha256& credential_hash) {
  return Read([&](Db& db) -> Result<StationRow> {
    Query q(db,
            "SELECT id, name, public_key, revoked, enrolled_ms, last_seen_ms FROM stations "
            "WHERE tenant = ?1 AND id = ?2 AND credential_hash = ?3");
    return OneStation(q.Bind(id).Bind(credential_hash), id);
  });
}

Result<StationRow> SqliteStore::StationById(const Uuid& id) {
  return Read([&](Db& db) -> Result<StationRow> {
    Query q(db,
            "SELECT id, name, public_key, revoked, enrolled_ms, last_seen_ms FROM stations "
            "WHERE tenant = ?1 AND id = ?2");
    return OneStation(q.Bind(id), id);
  });
}

Status SqliteStore::TouchStation(const Uuid& id, UnixMs now_ms) {
  return Write([&](Db& db) -> Status {
    Query q(db, "UPDATE stations SET last_seen_ms = ?3 WHERE tenant = ?1 AND id = ?2");
    return q.Bind(id).Bind(now_ms).Run();
  });
}

Result<std::vector<StationRow>> SqliteStore::Stations() {
  return Read([&](Db& db) -> Result<std::vector<StationRow>> {
    Query q(db,
            "SELECT id, name, public_key, revoked, enrolled_ms, last_seen_ms FROM stations "
            "WHERE tenant = ?1 ORDER BY name, id");
    std::vector<StationRow> out;
    while (q.Next()) out.push_back(StationOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server::sqlite
