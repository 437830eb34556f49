#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/store_options.h"

// database.json in a data folder (schemas/database.md): which PostgreSQL database holds the
// folder's rows, and which S3 stores its blobs and its keys. Without it rows are in enamel.db,
// blobs in blobs/ and keys in keyring/.
namespace enamel::server {

inline constexpr char kDatabaseFile[] = "database.json";

// As the file has it; texts that are absent are empty.
struct PlaceInS3 {
  std::string endpoint, region, bucket, prefix;
  std::string ca_file, credentials_file;
  bool operator==(const PlaceInS3&) const = default;
};

struct KeysInS3 {
  PlaceInS3 bucket;
  std::string master_key_file;
  bool operator==(const KeysInS3&) const = default;
};

struct DatabaseFile {
  std::string server;                // libpq's connection string
  std::string schema;                // of its tables
  std::optional<PlaceInS3> blobs{};  // none: in the folder
  std::optional<KeysInS3> keys{};    // none: in the folder
  bool operator==(const DatabaseFile&) const = default;
};

// None: there is no such file. Errors: kStorage, kInvalidInput, kVersion, kForbidden (it holds a
// password, and others may read it).
Result<std::optional<DatabaseFile>> ReadDatabaseFile(const std::filesystem::path& folder);

// The store, with the credentials of the file or of the environment (AWS_ACCESS_KEY_ID,
// AWS_SECRET_ACCESS_KEY). It is not asked. Errors: kInvalidInput, kForbidden (others may read the
// credentials), kStorage, kNotFound, kVersion. No message has a secret in it.
Result<S3Place> ReadS3Place(const std::filesystem::path& folder, const PlaceInS3& place);
// Errors: those of ReadS3Place. The file of the master key is not read.
Result<StoreOptions::KeyBucket> ReadKeyBucket(const std::filesystem::path& folder,
                                              const KeysInS3& keys);

// Puts an object there, gets it and deletes it. Errors: those of S3Client.
Status TryS3Place(const S3Place& place);

// For code that reads the rows in enamel.db itself. Errors: kConflict (they are in PostgreSQL;
// names the alternative to `command`).
Status MustHaveRowsInFolder(const std::filesystem::path& folder, const std::string& command);

// Errors: kInvalidInput (one bucket for blobs and keys), kConflict (the folder has rows already, in
// enamel.db or in another database, or blobs or keys elsewhere), and those of ReadDatabaseFile.
Status MayKeepRowsIn(const std::filesystem::path& folder, const DatabaseFile& file);

// Writes an S3 store's access key into a file that ReadS3Place reads as its credentials_file.
Status WriteCredentials(const std::filesystem::path& path, const s3::Credentials& key, Disk& disk);

// Errors: those of MayKeepRowsIn, kStorage.
Status WriteDatabaseFile(const std::filesystem::path& folder, const DatabaseFile& file, Disk& disk);

}  // namespace enamel::server
