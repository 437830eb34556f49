#include "server/storage/keys/master_key.h"

#include <sodium.h>

#include <array>

#include "server/storage/folder/private_file.h"
#include "server/storage/keys/envelope.h"

namespace enamel::server {
namespace {

constexpr std::string_view kWrappedMagic = "ENKW";
constexpr uint16_t kWrappedVersion = 1;
constexpr size_t kHexKey = 2 * DataKey::kBytes;
// Sub-keys of the master key (schemas/personal_data.md).
constexpr char kMasterContext[] = "ENKWkeys";
enum class MasterSubKey : uint64_t { kCipher = 1, kFingerprint = 2 };

DataKey SubKeyOf(const DataKey& master, MasterSubKey which) {
  return master.Derive(kMasterContext, static_cast<uint64_t>(which));
}

}  // namespace

Bytes MasterKey::Wrap(const Uuid& person, const DataKey& key) const {
  std::array<uint8_t, kEnvelopeNonce> nonce{};
  randombytes_buf(nonce.data(), nonce.size());
  return SealEnvelope({kWrappedMagic, kWrappedVersion, person},
                      SubKeyOf(key_, MasterSubKey::kCipher), nonce, key.view());
}

Result<DataKey> MasterKey::Unwrap(const Uuid& person, ByteView wrapped) const {
  const auto head = HeadOfEnvelope(wrapped, kWrappedMagic);
  if (!head || wrapped.size() != kWrappedBytes) {
    return Status(Code::kStorage, "expected the wrapped key of person " + person.Text() +
                                      ", found " + std::to_string(wrapped.size()) +
                                      " bytes of something else; restore it from a backup");
  }
  if (head->version != kWrappedVersion) {
    return Status(Code::kVersion, "the wrapped key of person " + person.Text() + " has version " +
                                      std::to_string(head->version) +
                                      ", this enamel-server reads " +
                                      std::to_string(kWrappedVersion) + "; run the newer one");
  }
  // Another person's key is not taken for this one's.
  auto plain = head->person == person ? OpenEnvelope(wrapped, SubKeyOf(key_, MasterSubKey::kCipher))
                                      : std::nullopt;
  if (!plain) {
    return Status(Code::kStorage,
                  "the wrapped key of person " + person.Text() +
                      " is damaged or another's, or was wrapped with another master "
                      "key; compare the master key files, or restore a backup");
  }
  DataKey key{ByteView(*plain)};
  sodium_memzero(plain->data(), plain->size());
  return key;
}

Sha256 MasterKey::Fingerprint() const {
  return HashSha256(SubKeyOf(key_, MasterSubKey::kFingerprint).view());
}

Result<MasterKey> ReadMasterKey(const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes text, ReadPrivateFile(path, 1024, "the school's master key",
                                                      "copy it from another server of the school"));
  auto digits = AsText(text);
  while (digits.ends_with('\n')) digits.remove_suffix(1);
  std::array<uint8_t, DataKey::kBytes> plain{};
  size_t size = 0;
  const bool good = digits.size() == kHexKey &&
                    sodium_hex2bin(plain.data(), plain.size(), digits.data(), digits.size(),
                                   nullptr, &size, nullptr) == 0 &&
                    size == DataKey::kBytes;
  const DataKey key{ByteView(plain)};
  sodium_memzero(plain.data(), plain.size());
  sodium_memzero(text.data(), text.size());
  if (good) return MasterKey(key);
  return Status(Code::kInvalidInput,
                path.string() +
                    ": expected a master key of 64 hexadecimal digits, found "
                    "something else; copy it from another server of the school");
}

Result<MasterKey> EnsureMasterKey(const std::filesystem::path& path, Disk& disk) {
  auto stored = ReadMasterKey(path);
  if (stored.ok() || stored.status().code() != Code::kNotFound) return stored;
  const DataKey key = DataKey::New();
  char text[kHexKey + 1];
  sodium_bin2hex(text, sizeof text, key.view().data(), DataKey::kBytes);
  text[kHexKey] = '\n';
  const Status written = disk.Replace(path, AsBytes({text, sizeof text}));
  sodium_memzero(text, sizeof text);
  ENAMEL_RETURN_IF_ERROR(written);
  return MasterKey(key);
}

}  // namespace enamel::server
