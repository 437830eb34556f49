#include "server/storage/people/station_rows.h"

#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"

// Enrolment codes and stations.
namespace enamel::server {
namespace {

constexpr char kStationSelect[] =
    "SELECT id, name, public_key, revoked, enrolled_ms, last_seen_ms, revoked_ms, software, "
    "core_version, revision FROM stations WHERE tenant = ?1";

Result<StationRow> FindStation(Db& db, const Uuid& id) {
  Query q(db, std::string(kStationSelect) + " AND id = ?2");
  return q.Bind(id).One<StationRow>("no station " + id.Text());
}

// A station comes back under its old id: with the key it had, or where nothing is known of it.
Status MayComeBack(Db& db, const StationRow& station) {
  auto stored = FindStation(db, station.id);
  if (stored.status().code() == Code::kNotFound) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(stored.status());
  // Recordings are signed with the key: under another one, the station's earlier recordings could
  // no longer be distinguished from forged ones.
  if (stored->public_key != station.public_key) {
    return Status(Code::kConflict,
                  "station " + station.id.Text() + " has another key; enrol as a new station",
                  "station_id");
  }
  if (!stored->revoked) return Status::Ok();
  return Status(Code::kConflict,
                "station " + station.id.Text() + " was revoked for good; enrol as a new station",
                "station_id");
}

// The same id with a new name and credential: its earlier recordings stay its own. The revision
// rises, so that an edit begun before is refused.
Status PutStation(Db& db, const StationRow& station, const Sha256& credential_hash) {
  return Insert(db, "stations", "id", station.id, "name", station.name, "public_key",
                station.public_key, "credential_hash", credential_hash, "enrolled_ms",
                station.enrolled_ms, "last_seen_ms", station.enrolled_ms,
                " ON CONFLICT (tenant, id) DO UPDATE SET name = excluded.name, credential_hash = "
                "excluded.credential_hash, enrolled_ms = excluded.enrolled_ms, last_seen_ms = "
                "excluded.last_seen_ms, revision = stations.revision + 1");
}

Result<Uuid> IdOfEnrolCode(Db& db, const Sha256& code_hash) {
  Query q(db, "SELECT id FROM enrol_codes WHERE tenant = ?1 AND code_hash = ?2");
  return q.Bind(code_hash).One<Uuid>("no such enrolment code");
}

}  // namespace

Result<Uuid> StationRows::AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms,
                                       const Actor& by) {
  Uuid id = Uuid::New();
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(Insert(db, "enrol_codes", "code_hash", code_hash, "id", id, "created_ms",
                                  NowMs(), "expires_ms", expires_ms));
    return WriteAudit(db, by, "station.code", id.Text(), "{}",
                      JsonOf({{"expires_ms", std::to_string(expires_ms)}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return id;
}

Result<std::vector<EnrolCodeRow>> StationRows::OpenEnrolCodes(UnixMs now_ms) {
  return rows_.Read([&](Db& db) -> Result<std::vector<EnrolCodeRow>> {
    Query q(db,
            "SELECT id, created_ms, expires_ms FROM enrol_codes WHERE tenant = ?1 AND used_ms IS "
            "NULL AND withdrawn_ms IS NULL AND expires_ms >= ?2 ORDER BY expires_ms, id");
    return q.Bind(now_ms).All<EnrolCodeRow>();
  });
}

Status StationRows::WithdrawEnrolCode(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    {
      Query q(db, "SELECT used_ms, withdrawn_ms FROM enrol_codes WHERE tenant = ?1 AND id = ?2");
      if (!q.Bind(id).Next()) {
        return q.status().ok() ? Status(Code::kNotFound, "no enrolment code " + id.Text())
                               : q.status();
      }
      // Too late to withdraw: the station is in already.
      if (!q.IsNull(0)) {
        return Status(Code::kConflict,
                      "a station has enrolled with this code already; revoke the station instead");
      }
      if (!q.IsNull(1)) return Status::Ok();
    }
    Query q(db, "UPDATE enrol_codes SET withdrawn_ms = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, NowMs()).Run());
    return WriteAudit(db, by, "station.code_withdrawn", id.Text(), "{}", "{}");
  });
}

Result<bool> StationRows::IsEnrolCode(const Sha256& code_hash) {
  return rows_.Read([&](Db& db) -> Result<bool> {
    Query q(db, "SELECT 1 FROM enrol_codes WHERE tenant = ?1 AND code_hash = ?2");
    return q.Bind(code_hash).Any();
  });
}

Result<StationRow> StationRows::EnrolStation(const Sha256& code_hash, StationRow station,
                                             const Sha256& credential_hash, UnixMs now_ms) {
  const bool again = !station.id.IsZero();
  if (!again) station.id = Uuid::New();
  station.enrolled_ms = station.last_seen_ms = now_ms;
  Status status = rows_.Write([&](Db& db) -> Status {
    // Used up in the statement that looks whether it may be: two stations at once cannot both have
    // it. What comes after may still fail, and takes the use back with it.
    Query use(db,
              "UPDATE enrol_codes SET used_ms = ?3 WHERE tenant = ?1 AND code_hash = ?2 AND "
              "used_ms IS NULL AND withdrawn_ms IS NULL AND expires_ms >= ?3");
    ENAMEL_RETURN_IF_ERROR(use.Bind(code_hash, now_ms).Run());
    if (db.Changes() == 0) {
      return Status(Code::kUnauthenticated,
                    "the enrolment code is unknown, used or expired; ask an admin for a new one");
    }
    if (again) ENAMEL_RETURN_IF_ERROR(MayComeBack(db, station));
    ENAMEL_RETURN_IF_ERROR(PutStation(db, station, credential_hash));
    const Actor by{{}, "station " + station.name};
    ENAMEL_ASSIGN_OR_RETURN(const Uuid code, IdOfEnrolCode(db, code_hash));
    ENAMEL_RETURN_IF_ERROR(WriteAudit(db, by, "station.code_used", code.Text(), "{}",
                                      JsonOf({{"name", station.name}})));
    return WriteAudit(db, by, again ? "station.enrol_again" : "station.enrol", station.id.Text(),
                      "{}", JsonOf({{"name", station.name}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return station;
}

// The database compares: the time it takes reveals a hash at most, and nothing of the credential.
Result<StationRow> StationRows::StationByCredential(const Uuid& id, const Sha256& credential_hash) {
  return rows_.Read([&](Db& db) -> Result<StationRow> {
    Query q(db, std::string(kStationSelect) + " AND id = ?2 AND credential_hash = ?3");
    return q.Bind(id, credential_hash).One<StationRow>("no station " + id.Text());
  });
}

Result<StationRow> StationRows::StationById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindStation(db, id); });
}

// No audit row: it comes with every connection and says nothing that somebody did.
Status StationRows::TouchStation(const Uuid& id, const std::string& software, uint32_t core_version,
                                 UnixMs now_ms) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db,
            "UPDATE stations SET last_seen_ms = ?3, software = ?4, core_version = ?5 WHERE tenant "
            "= ?1 AND id = ?2");
    return q.Bind(id, now_ms, software, core_version).Run();
  });
}

Result<StationRow> StationRows::RenameStation(const Uuid& id, const std::string& name,
                                              int32_t revision, const Actor& by) {
  Result<StationRow> after = StationRow{};
  Status status = rows_.Write([&](Db& db) -> Status {
    after = FindStation(db, id);
    ENAMEL_RETURN_IF_ERROR(after.status());
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(after->revision, revision));
    if (after->name == name) return Status::Ok();
    {
      Query other(db, "SELECT 1 FROM stations WHERE tenant = ?1 AND name = ?2 AND revoked = 0");
      if (other.Bind(name).Next()) {
        return Status(Code::kConflict,
                      "expected a name that no other station has, found \"" + name + "\"", "name");
      }
      ENAMEL_RETURN_IF_ERROR(other.status());
    }
    std::string before = std::exchange(after->name, name);
    ++after->revision;
    Query q(db, "UPDATE stations SET name = ?3, revision = ?4 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, name, after->revision).Run());
    return WriteAudit(db, by, "station.rename", id.Text(), JsonOf({{"name", before}}),
                      JsonOf({{"name", name}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return after;
}

Status StationRows::RevokeStation(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto station, FindStation(db, id));
    // Revoked once is revoked for good; the first time counts.
    if (station.revoked) return Status::Ok();
    Query q(db,
            "UPDATE stations SET revoked = 1, revoked_ms = ?3, revision = revision + 1 WHERE "
            "tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, NowMs()).Run());
    return WriteAudit(db, by, "station.revoke", id.Text(), JsonOf({{"name", station.name}}), "{}");
  });
}

Result<std::vector<StationRow>> StationRows::Stations() {
  return rows_.Read([&](Db& db) -> Result<std::vector<StationRow>> {
    Query q(db, std::string(kStationSelect) + " ORDER BY name, id");
    return q.All<StationRow>();
  });
}

Result<std::vector<Uuid>> StationRows::RevokedStations() {
  return rows_.Read([&](Db& db) -> Result<std::vector<Uuid>> {
    Query q(db, "SELECT id FROM stations WHERE tenant = ?1 AND revoked = 1");
    return q.All<Uuid>();
  });
}

}  // namespace enamel::server
