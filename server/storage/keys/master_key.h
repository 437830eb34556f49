#pragma once

#include <filesystem>

#include "server/storage/folder/disk.h"
#include "server/storage/keys/envelope.h"
#include "server/storage/keys/keyring.h"

namespace enamel::server {

// Wraps the keys of people that are kept in a bucket (schemas/personal_data.md, "Keys in a
// bucket"): the bucket alone opens nothing. 256 bits in a file outside the bucket, the same on all
// servers of a school. Thread safety: const after construction.
class MasterKey {
 public:
  static constexpr size_t kWrappedBytes = kEnvelopeBytes + DataKey::kBytes;

  explicit MasterKey(const DataKey& key) : key_(key) {}

  // A fresh nonce each time: the same key gives other bytes.
  Bytes Wrap(const Uuid& person, const DataKey& key) const;
  // Errors: kStorage (damaged, another person's, or wrapped with another master key), kVersion.
  Result<DataKey> Unwrap(const Uuid& person, ByteView wrapped) const;
  // Tells whether two servers have the same, and nothing else of it.
  Sha256 Fingerprint() const;

 private:
  DataKey key_;
};

// A file of 64 hexadecimal digits and a newline that nobody but its owner may read. Errors:
// kNotFound, kForbidden (others may read it), kInvalidInput (it is no key), kStorage. No message
// has the key in it.
Result<MasterKey> ReadMasterKey(const std::filesystem::path& path);
// Made at random when absent.
Result<MasterKey> EnsureMasterKey(const std::filesystem::path& path, Disk& disk);

}  // namespace enamel::server
