#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/folder/disk.h"
#include "server/storage/verify/verify.h"
#include "server/training/types.h"

// Backup and restore of a school (schemas/backup.md). A backup reads a data folder, or the
// PostgreSQL database and S3 stores that its database.json names. A restore always writes a folder
// (from there, use move.h).
namespace enamel::server {

struct BackupOptions {
  std::filesystem::path data;     // in use or not
  std::filesystem::path target;   // absent or empty
  std::filesystem::path keyring;  // where keys and erasures go instead; empty: into the backup
  bool copy = false;              // never link blobs, also on the same file system
  std::string software;
  UpkeepProgress progress{};
  Disk* disk = nullptr;  // null: the machine's
};

struct BackupReport {
  UnixMs created_ms = 0;
  uint64_t files = 0, bytes = 0;
  uint64_t linked = 0;  // of the files
  uint64_t people = 0, attempts = 0, ticks = 0;
  // Blobs that the database names and that are absent or damaged: everything else was backed up.
  std::vector<Sha256> missing;
};

// Consistent as of one moment, while a server writes. Ok with `missing` not empty: the caller must
// report it. Written to `target`.part, and renamed when all of it is on the disk. Errors: kConflict
// (target not empty, or files of somebody's in its .part), kNotFound (no data folder), kUnavailable
// (recordings are being removed; another backup is being written there), kStorage; after an error
// there is neither.
Result<BackupReport> BackUp(const BackupOptions& options);

// A place in this folder that no other backup has: by this name, or with "-2", "-3" … after it. Its
// .part is there, so that nobody else gets it. Removes what killed backups left. Errors: kStorage.
Result<std::filesystem::path> NewBackupIn(const std::filesystem::path& folder,
                                          const std::string& name);

struct RestoreOptions {
  std::filesystem::path backup;
  std::filesystem::path data;  // absent or empty
  // Key rings newer than the backup's: their erasures are applied, their keys are taken. Needed
  // when the backup has none.
  std::vector<std::filesystem::path> keyrings;
  bool accept_damage = false;  // go on without blobs and keys that are missing or damaged
  UpkeepProgress progress{};
  Disk* disk = nullptr;
};

struct RestoreReport {
  UnixMs created_ms = 0;  // of the backup
  uint64_t files = 0, bytes = 0;
  size_t erased_again = 0;            // people
  std::vector<std::string> left_out;  // files that were missing or damaged
  VerifyReport verified;
};

// Errors: kConflict (data folder not empty; a key ring is needed), kInvalidInput (no backup, or an
// unfinished or damaged one: says which files), kVersion, kStorage. After an error the data folder
// keeps its mark and no server starts on it.
Result<RestoreReport> Restore(const RestoreOptions& options);

}  // namespace enamel::server
