#include "server/storage/migrate.h"

namespace enamel::server::sqlite {
namespace {

// "Enml": marks the file as ours (PRAGMA application_id).
constexpr int64_t kApplicationId = 0x456e6d6c;

Result<int64_t> Pragma(Db& db, const char* sql) {
  Query q(db, sql, Query::kNoTenant);
  int64_t value = q.Next() ? q.Int(0) : 0;
  if (!q.status().ok()) return q.status();
  return value;
}

}  // namespace

Result<int> SchemaVersion(Db& db) {
  ENAMEL_ASSIGN_OR_RETURN(auto version, Pragma(db, "PRAGMA user_version"));
  ENAMEL_ASSIGN_OR_RETURN(auto application, Pragma(db, "PRAGMA application_id"));
  if (version != 0 && application != kApplicationId) {
    return Status(Code::kVersion,
                  db.path() + " is a database of another program; name another data folder");
  }
  int latest = static_cast<int>(Migrations().size());
  if (version > latest) {
    return Status(Code::kVersion,
                  db.path() + " has schema version " + std::to_string(version) +
                      ", this enamel-server knows up to " + std::to_string(latest) +
                      "; run the newer enamel-server that made it, or restore a backup");
  }
  return static_cast<int>(version);
}

Status Migrate(Db& db) {
  ENAMEL_ASSIGN_OR_RETURN(auto version, SchemaVersion(db));
  for (size_t next = static_cast<size_t>(version); next < Migrations().size(); ++next) {
    const Migration& migration = Migrations()[next];
    std::string sql = "BEGIN IMMEDIATE;\n" + migration.sql +
                      "\nPRAGMA application_id = " + std::to_string(kApplicationId) +
                      ";\nPRAGMA user_version = " + std::to_string(next + 1) + ";\nCOMMIT;";
    if (Status status = db.Exec(sql.c_str()); !status.ok()) {
      db.Rollback();
      return Status(status.code(), "migration " + migration.name + ": " + status.message());
    }
  }
  return Status::Ok();
}

}  // namespace enamel::server::sqlite
