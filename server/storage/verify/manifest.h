#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/storage/audit/audit_row.h"

namespace enamel::server {

inline constexpr char kManifestName[] = "manifest.json";
inline constexpr char kPartSuffix[] = ".part";  // of a backup that is being written

// schemas/backup.md, "manifest.json".
struct Manifest {
  struct File {
    std::string path;
    uint64_t bytes = 0;
    Sha256 hash;
  };
  int64_t created_ms = 0;
  std::string software;
  int schema = 0;
  bool keyring_inside = true;
  uint64_t people = 0, attempts = 0, ticks = 0;
  std::vector<AuditHead> trail{};  // where the audit trail ended
  std::vector<File> files{};       // sorted by path
};

std::string ToJson(const Manifest& manifest);
// Errors: kInvalidInput (names the member), kVersion.
Result<Manifest> ManifestFromJson(std::string_view text);
// Errors: those, and kInvalidInput when the folder is no finished backup.
Result<Manifest> ReadManifest(const std::filesystem::path& backup);
// The newest of the finished backups that are directly in this folder: schemas/backup.md, "The
// newest". Errors: kNotFound (there is none), kStorage.
Result<std::filesystem::path> NewestBackup(const std::filesystem::path& folder);

}  // namespace enamel::server
