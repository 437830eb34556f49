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

Result<std::optional<ProfileRow>> Newest(Db& db, const std::string& name) {
  Query q(db, std::string(kVersionSelect) + " AND name = ?2 ORDER BY version DESC LIMIT 1");
  return q.Bind(name).Maybe<ProfileRow>();
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
  ENAMEL_RETURN_IF_ERROR(Insert(db, "profiles", "name", row.name, "title", row.title, "content",
                                row.content,
                                " ON CONFLICT (tenant, name) DO UPDATE SET title = excluded.title, "
                                "content = excluded.content"));
  return Insert(db, "profile_versions", "name", row.name, "version", row.version, "title",
                row.title, "content", row.content, "created_ms", row.created_ms);
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
    Query q(db, std::string(kVersionSelect) +
                    " AND version = (SELECT max(version) FROM profile_versions n WHERE n.tenant = "
                    "v.tenant AND "
                    "n.name = v.name) ORDER BY name");
    return q.All<ProfileRow>();
  });
}

Result<std::vector<ProfileRow>> ProfileRows::ProfileVersions(const std::string& name) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ProfileRow>> {
    Query q(db, std::string(kVersionSelect) + " AND name = ?2 ORDER BY version DESC");
    return q.Bind(name).All<ProfileRow>();
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
      Query q(db, std::string(kReportSelect) + " AND name = ?2 AND version = ?3 AND content = ?4");
      if (q.Bind(row.profile, profile.version, row.content).Next()) {
        added = q.Row<ProfileReportRow>();
        return Status::Ok();
      }
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    added.id = Uuid::New();
    added.version = profile.version;
    added.created_ms = NowMs();
    ENAMEL_RETURN_IF_ERROR(Insert(db, "profile_reports", "id", added.id, "name", added.profile,
                                  "version", added.version, "media_type", added.media_type,
                                  "content", added.content, "bytes", added.bytes, "created_ms",
                                  added.created_ms));
    return WriteAudit(
        db, by, "profile.report", row.profile, "{}",
        JsonOf({{"version", std::to_string(added.version)}, {"content", added.content.Hex()}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return added;
}

Result<std::vector<ProfileReportRow>> ProfileRows::ProfileReports(const std::string& profile) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ProfileReportRow>> {
    Query q(db, std::string(kReportSelect) + " AND name = ?2 ORDER BY id DESC");
    return q.Bind(profile).All<ProfileReportRow>();
  });
}

Result<ProfileReportRow> ProfileRows::ProfileReportById(const Uuid& id) {
  return rows_.Read([&](Db& db) -> Result<ProfileReportRow> {
    Query q(db, std::string(kReportSelect) + " AND id = ?2");
    return q.Bind(id).One<ProfileReportRow>("no report " + id.Text());
  });
}

Result<CalibrationRow> ProfileRows::AddCalibration(const CalibrationRow& row, const Actor& by) {
  CalibrationRow added;
  Status status = rows_.Write([&](Db& db) -> Status {
    added = row;
    // Compared as a whole: a document that differs anywhere is another measurement.
    if (auto profile = MustBeThere(db, row.profile); !profile.ok()) return profile.status();
    {
      Query q(db, std::string(kCalibrationSelect) + " AND profile = ?2 AND document = ?3");
      if (q.Bind(row.profile, row.document).Next()) {
        added = q.Row<CalibrationRow>();
        return Status::Ok();
      }
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    added.id = Uuid::New();
    added.added_ms = NowMs();
    ENAMEL_RETURN_IF_ERROR(Insert(db, "calibrations", "id", added.id, "profile", added.profile,
                                  "device", added.device, "measured_ms", added.measured_ms,
                                  "added_ms", added.added_ms, "document", added.document));
    return WriteAudit(db, by, "profile.calibration", row.profile, "{}",
                      JsonOf({{"id", added.id.Text()}, {"device", added.device}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return added;
}

Result<std::vector<CalibrationRow>> ProfileRows::Calibrations(const std::string& profile) {
  return rows_.Read([&](Db& db) -> Result<std::vector<CalibrationRow>> {
    Query q(db, std::string(kCalibrationSelect) +
                    " AND profile = ?2 ORDER BY measured_ms DESC, id DESC");
    return q.Bind(profile).All<CalibrationRow>();
  });
}

}  // namespace enamel::server
