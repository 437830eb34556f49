#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "server/storage/engine/disk.h"

// database.json in a data folder: which PostgreSQL database holds the folder's rows. Without it they
// are in enamel.db.
//   {"version": 1, "server": "postgresql://user@host/name", "schema": "enamel"}
// Unknown members are ignored; a file of another version is refused. Mode 0600: `server` may hold a
// password, though libpq's ~/.pgpass or PGPASSFILE is the better place.
namespace enamel::server {

inline constexpr char kDatabaseFile[] = "database.json";

struct DatabaseFile {
  std::string server;  // libpq's connection string
  std::string schema;  // of its tables
};

// None: there is no such file. Errors: kStorage, kInvalidInput, kVersion.
Result<std::optional<DatabaseFile>> ReadDatabaseFile(const std::filesystem::path& folder);

// For what looks at the rows in enamel.db itself. Errors: kConflict (they are in PostgreSQL, with what
// to do instead of `command`).
Status MustHaveRowsInFolder(const std::filesystem::path& folder, const std::string& command);

// Errors: kConflict (the folder has rows already, in enamel.db or in another database), and those of
// ReadDatabaseFile.
Status MayKeepRowsIn(const std::filesystem::path& folder, const DatabaseFile& file);

// Errors: those of MayKeepRowsIn, kStorage.
Status WriteDatabaseFile(const std::filesystem::path& folder, const DatabaseFile& file, Disk& disk);

}  // namespace enamel::server
