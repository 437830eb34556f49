#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/sqlite/sqlite_db.h"

// enamel.db, as the server opens it.
namespace enamel::server {

using sql::Db;
using sql::SqliteDb;

// In order, from version 1. Generated from schemas/sql.
const std::vector<sql::Migration>& SqliteMigrations();
// The newest that this program knows; the same for every engine.
int LatestSchemaVersion();

// A failure gives the caller the remedy, without path or SQLite's words: those go to the log. While
// opening, whoever started the program sees them too. `vfs`: SQLite's name of the file layer to
// use; empty: its own. `fail_next`: SqliteDbOptions.
using DbMode = sql::SqliteDbOptions::Mode;
Result<std::unique_ptr<SqliteDb>> OpenDatabase(const std::filesystem::path& path, DbMode mode,
                                               const std::string& vfs = {},
                                               std::function<bool()> fail_next = {});

// Ok too where there is no file, and where the file has no mark yet. Changes nothing and drops no lock
// of this process. Errors: kVersion (another program's, or a development version's).
Status MustBeOurs(const std::filesystem::path& path, const std::string& vfs);

// Schema version of an open database, 0 when empty. Errors: kVersion when newer than this program
// or not ours at all.
Result<int> SchemaVersion(Db& db);

}  // namespace enamel::server
