#pragma once

#include <filesystem>
#include <unordered_map>
#include <vector>

#include "common/base/mutex.h"
#include "server/storage/folder/disk.h"
#include "server/storage/keys/keyring.h"

namespace enamel::server {

// FOLDER/<uuid>.key and FOLDER/gone/<sha256>, schemas/personal_data.md.
//
// Several processes may share the folder. Thread safety: any thread.
class FolderKeyring final : public Keyring {
 public:
  FolderKeyring(std::filesystem::path folder, Disk& disk)
      : folder_(std::move(folder)), disk_(disk) {}

  Result<DataKey> Find(const Uuid& person) override;
  Result<DataKey> FindOrMake(const Uuid& person) override;
  // Tombstone first, then the key.
  Status Destroy(const Uuid& person, int64_t now_ms) override;
  Result<bool> IsGone(const Uuid& person) override;
  // Errors: kStorage, kInvalidInput (a file that does not belong).
  Result<std::vector<Tombstone>> Gone() override;
  // Errors: those of Gone.
  Result<std::vector<Uuid>> People() override;
  Status Put(const Uuid& person, const DataKey& key) override;
  Status Bury(const std::vector<Tombstone>& tombstones) override;

  // Join (keyring.h), and no keys but the other's.
  Status MirrorFrom(Keyring& other);

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path KeyPath(const Uuid& person) const;
  std::filesystem::path GonePath(const Sha256& person) const;
  bool HasTombstone(const Uuid& person) const;
  Result<DataKey> Read(const Uuid& person) const;
  Status Mark(const Tombstone& tombstone);

  const std::filesystem::path folder_;
  Disk& disk_;
  Mutex mutex_;
  std::unordered_map<std::string, DataKey> found_ ENAMEL_GUARDED_BY(mutex_);  // by id bytes
};

}  // namespace enamel::server
