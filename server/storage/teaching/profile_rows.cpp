#include "server/storage/teaching/profile_rows.h"

#include <optional>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"

// Device profiles: every version, reports about them, calibrations of devices.
namespace enamel::server {
namespace {

constexpr char kVersionSelect[] =
    "SELECT name, title, content, version, created_ms FROM profile_versions v WHERE tenant = ?1";
constexpr char kReportSelect[] =
    "SELECT id, name, version, media_type, content, bytes, created_ms FROM profile_reports "
    "WHERE tenant = ?1";
constexpr char kCalibrationSelect[] =
    "SELECT id, profile, device, measured_ms, added_ms, document FROM calibrations "
    "WHERE tenant = ?1";

Result<std::vector<ProfileRow>> ProfilesIn(Query& q) {
  std::vector<ProfileRow> out;
  while (q.Next()) {
    out.push_back({q.Text(0), q.Text(1), q.Hash(2), static_cast<int32_t>(q.Int(3)), q.Int(4)});
  }
  if (!q.status().ok()) return q.status();
  return out;
}

ProfileReportRow ReportOf(const Query& q) {
  return {q.Id(0),   q.Text(1), static_cast<int32_t>(q.Int(2)),
          q.Text(3), q.Hash(4), static_cast<uint64_t>(q.Int(5)),
          q.Int(6)};
}

CalibrationRow CalibrationOf(const Query& q) {
  return {q.Id(0), q.Text(1), q.Text(2), q.Int(3), q.Int(4), q.Text(5)};
}

Result<std::optional<ProfileRow>> Newest(Db& db, const std::string& name) {
  static const std::string kSql =
      std::string(kVersionSelect) + " AND name = ?2 ORDER BY version DESC LIMIT 1";
  Query q(db, kSql.c_str());
  ENAMEL_ASSIGN_OR_RETURN(auto rows, ProfilesIn(q.Bind(name)));
  return rows.empty() ? std::optional<ProfileRow>() : rows.front();
}

// An addition is about the version that is the newest now.
Result<ProfileRow> MustBeThere(Db& db, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto found, Newest(db, name));
  if (found) return *found;
  return Status(Code::kNotFound, "no device profile named \"" + name + "\"; put the profile first",
                "profile");
}

// `profile_versions` keeps them all; `profiles` has the newest of each, which calibrations refer
// to by its name.
Status InsertVersion(Db& db, const ProfileRow& row) {
  {
    Query q(db,
            "INSERT INTO profiles (tenant, name, title, content) VALUES (?1, ?2, ?3, ?4) ON "
            "CONFLICT (tenant, name) DO UPDATE SET title = excluded.title, content = "
            "excluded.content");
    ENAMEL_RETURN_IF_ERROR(q.Bind(row.name).Bind(row.title).Bind(row.content).Run());
  }
  Query q(db,
          "INSERT INTO profile_versions (tenant, name, version, title, content, created_ms) VALUES "
          "(?1, ?2, ?3, ?4, ?5, ?6)");
  q.Bind(row.name).Bind(int64_t{row.version}).Bind(row.title).Bind(row.content);
  return q.Bind(row.created_ms).Run();
}

}  // namespace

Status ProfileRows::PutProfile(const ProfileRow& row, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto newest, Newest(db, row.name));
    // A version that differs in nothing would say nothing.
    if (newest && newest->content == row.content) return Status::Ok();
    ProfileRow next = row;
    next.version = newest ? newest->version + 1 : 1;
    next.created_ms = NowMs();
    ENAMEL_RETURN_IF_ERROR(InsertVersion(db, next));
    auto json = [](const ProfileRow& profile) {
      return JsonOf(
          {{"version", std::to_string(profile.version)}, {"content", profile.content.Hex()}});
    };
    return WriteAudit(db, by, "profile.put", row.name, newest ? json(*newest) : "{}", json(next));
  });
}

Result<std::vector<ProfileRow>> ProfileRows::Profiles() {
  return rows_.Read([&](Db& db) -> Result<std::vector<ProfileRow>> {
    static const std::string kSql =
        std::string(kVersionSelect) +
        " AND version = (SELECT max(version) FROM profile_versions n WHERE n.tenant = v.tenant AND "
        "n.name = v.name) ORDER BY name";
    Query q(db, kSql.c_str());
    return ProfilesIn(q);
  });
}

Result<std::vector<ProfileRow>> ProfileRows::ProfileVersions(const std::string& name) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ProfileRow>> {
    static const std::string kSql =
        std::string(kVersionSelect) + " AND name = ?2 ORDER BY version DESC";
    Query q(db, kSql.c_str());
    return ProfilesIn(q.Bind(name));
  });
}

Result<ProfileReportRow> ProfileRows::AddProfileReport(const ProfileReportRow& row,
                                                       const Actor& by) {
  // Puts the blob before its row, never after: a row must name an existing blob. A crash in between
  // leaves a blob that no row names; retention sweeps it away.
  if (!blobs_.Has(row.content)) {
    return Status(Code::kNotFound, "the report is not stored; put its blob first");
  }
  ProfileReportRow added;
  Status status = rows_.Write([&](Db& db) -> Status {
    added = row;
    // The same report of the same version returns the existing row: it may be sent twice.
    ENAMEL_ASSIGN_OR_RETURN(auto profile, MustBeThere(db, row.profile));
    {
      static const std::string kSql =
          std::string(kReportSelect) + " AND name = ?2 AND version = ?3 AND content = ?4";
      Query q(db, kSql.c_str());
      if (q.Bind(row.profile).Bind(int64_t{profile.version}).Bind(row.content).Next()) {
        added = ReportOf(q);
        return Status::Ok();
      }
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    added.id = Uuid::New();
    added.version = profile.version;
    added.created_ms = NowMs();
    Query q(db,
            "INSERT INTO profile_reports (tenant, id, name, version, media_type, content, bytes, "
            "created_ms) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
    q.Bind(added.id).Bind(added.profile).Bind(int64_t{added.version}).Bind(added.media_type);
    q.Bind(added.content).Bind(static_cast<int64_t>(added.bytes)).Bind(added.created_ms);
    ENAMEL_RETURN_IF_ERROR(q.Run());
    return WriteAudit(
        db, by, "profile.report", row.profile, "{}",
        JsonOf({{"version", std::to_string(added.version)}, {"content", added.content.Hex()}}));
  });
  if (!status.ok()) return status;
  return added;
}

Result<std::vector<ProfileReportRow>> ProfileRows::ProfileReports(const std::string& profile) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ProfileReportRow>> {
    static const std::string kSql = std::string(kReportSelect) + " AND name = ?2 ORDER BY id DESC";
    Query q(db, kSql.c_str());
    q.Bind(profile);
    std::vector<ProfileReportRow> out;
    while (q.Next()) out.push_back(ReportOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Result<ProfileReportRow> ProfileRows::ProfileReportById(const Uuid& id) {
  return rows_.Read([&](Db& db) -> Result<ProfileReportRow> {
    static const std::string kSql = std::string(kReportSelect) + " AND id = ?2";
    Query q(db, kSql.c_str());
    if (q.Bind(id).Next()) return ReportOf(q);
    if (!q.status().ok()) return q.status();
    return Status(Code::kNotFound, "no report " + id.Text());
  });
}

Result<CalibrationRow> ProfileRows::AddCalibration(const CalibrationRow& row, const Actor& by) {
  CalibrationRow added;
  Status status = rows_.Write([&](Db& db) -> Status {
    added = row;
    // Compared as a whole: a document that differs anywhere is another measurement.
    if (auto profile = MustBeThere(db, row.profile); !profile.ok()) return profile.status();
    {
      static const std::string kSql =
          std::string(kCalibrationSelect) + " AND profile = ?2 AND document = ?3";
      Query q(db, kSql.c_str());
      if (q.Bind(row.profile).Bind(row.document).Next()) {
        added = CalibrationOf(q);
        return Status::Ok();
      }
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    added.id = Uuid::New();
    added.added_ms = NowMs();
    Query q(db,
            "INSERT INTO calibrations (tenant, id, profile, device, measured_ms, added_ms, "
            "document) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    q.Bind(added.id).Bind(added.profile).Bind(added.device).Bind(added.measured_ms);
    ENAMEL_RETURN_IF_ERROR(q.Bind(added.added_ms).Bind(added.document).Run());
    return WriteAudit(db, by, "profile.calibration", row.profile, "{}",
                      JsonOf({{"id", added.id.Text()}, {"device", added.device}}));
  });
  if (!status.ok()) return status;
  return added;
}

Result<std::vector<CalibrationRow>> ProfileRows::Calibrations(const std::string& profile) {
  return rows_.Read([&](Db& db) -> Result<std::vector<CalibrationRow>> {
    static const std::string kSql =
        std::string(kCalibrationSelect) + " AND profile = ?2 ORDER BY measured_ms DESC, id DESC";
    Query q(db, kSql.c_str());
    q.Bind(profile);
    std::vector<CalibrationRow> out;
    while (q.Next()) out.push_back(CalibrationOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server
