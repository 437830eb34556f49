#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/engine/disk.h"

namespace enamel::server {

// 256 bits under which one person's recordings are kept. Wiped when it goes out of scope.
class DataKey {
 public:
  DataKey() = default;
  explicit DataKey(ByteView bytes);  // Requires: 32 bytes.
  ~DataKey();
  DataKey(const DataKey&) = default;
  DataKey& operator=(const DataKey&) = default;
  static DataKey New();
  ByteView view() const { return bytes_; }

 private:
  std::array<uint8_t, 32> bytes_{};
};

// The person in the list of erasures: enough to recognise an id that turns up again, not to find
// one.
Sha256 TombstoneOf(const Uuid& person);

struct Tombstone {
  Sha256 person;
  int64_t erased_ms = 0;
};

// FOLDER/<uuid>.key and FOLDER/gone/<sha256>, schemas/personal_data.md. Apart from the database and
// the blobs, so that destroying a key takes what it opens out of every copy of those.
//
// Several processes may share the folder. Thread safety: any thread.
class Keyring {
 public:
  Keyring(std::filesystem::path folder, Disk& disk) : folder_(std::move(folder)), disk_(disk) {}

  // Errors: kNotFound (never had one, or erased).
  Result<DataKey> Find(const Uuid& person);
  // Made, and durable, when there is none. Errors: kConflict (erased), kStorage.
  Result<DataKey> FindOrMake(const Uuid& person);
  // Tombstone first, then the key: whatever happens in between, the person counts as erased.
  Status Destroy(const Uuid& person, int64_t now_ms);
  bool IsGone(const Uuid& person) const;

  // Whose keys are here, in order. Errors: kStorage, kInvalidInput (a file that does not belong).
  Result<std::vector<Uuid>> People() const;
  Result<std::vector<Tombstone>> Gone() const;

  // These people are erased here too, from now on.
  Status Bury(const std::vector<Tombstone>& tombstones);
  // Takes the other's keys and erasures besides those here.
  Status Join(const Keyring& other);
  // Join, and no keys but the other's.
  Status MirrorFrom(const Keyring& other);

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path KeyPath(const Uuid& person) const;
  std::filesystem::path GonePath(const Sha256& person) const;
  Result<DataKey> Read(const Uuid& person) const;
  Status Mark(const Tombstone& tombstone);

  const std::filesystem::path folder_;
  Disk& disk_;
  std::mutex mutex_;
  std::unordered_map<std::string, DataKey> found_;  // guarded by mutex_; by id bytes
};

// What is kept under a person's key (schemas/personal_data.md, "Envelope"). The same data of the
// same attempt gives the same bytes, so that writing it again after a crash changes nothing.
Bytes SealPersonal(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data);
// None: these bytes are no envelope.
std::optional<Uuid> PersonOfSealed(ByteView bytes);
// Envelopes are opened, everything else is returned as it is (written before schema 2, or
// nobody's). Errors: kNotFound (key destroyed), kStorage (damaged), kVersion.
Result<Bytes> OpenPersonal(Keyring& keyring, Bytes bytes);
// Whether an envelope was made of something of this attempt: its nonce is derived from that and the
// content. Errors: those of OpenPersonal; kInvalidInput (these bytes are no envelope).
Result<bool> IsOfAttempt(Keyring& keyring, const Bytes& sealed, const Uuid& attempt);

}  // namespace enamel::server
