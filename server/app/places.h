#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/open_store.h"

// Where a school's rows, blobs and keys are to be, as the command line says it: for `init` and
// `move`.
namespace enamel::server::app {

struct Places {
  std::string database;  // of PostgreSQL; empty: SQLite in the folder
  std::string schema = "enamel";
  PlaceInS3 blobs;  // without an endpoint: in the folder
  KeysInS3 keys;    // without a bucket: in the folder
};

// None: all of it in the folder. Errors: kInvalidInput (an S3 store without a database).
Result<std::optional<DatabaseFile>> FileOf(const Places& places);

// Tries the stores that the file names. Errors: those of S3Client, and of a key bucket that does
// not forget deleted objects.
Status TryStores(const std::filesystem::path& folder, const DatabaseFile& file);

// Options to open a folder that has no database.json yet. Only a school's first server creates the
// master key: on another server a mistyped path must not create one.
Result<PostgresOptions> FirstOptions(const std::filesystem::path& folder, const DatabaseFile& file);

}  // namespace enamel::server::app
