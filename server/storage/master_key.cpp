#include "server/storage/master_key.h"

#include <sodium.h>

#include <algorithm>

#include "server/storage/engine/private_file.h"

namespace enamel::server {
namespace {

constexpr char kMagic[] = {'E', 'N', 'W', 'K'};
constexpr uint16_t kVersion = 1;
constexpr size_t kHeadBytes = 4 + 2 + 2 + 16;
constexpr size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
constexpr size_t kWrappedBytes = kHeadBytes + kNonceBytes + DataKey::kBytes + kTagBytes;
constexpr size_t kHexKey = 2 * DataKey::kBytes;
// Sub-keys of the master key (schemas/personal_data.md).
constexpr char kContext[crypto_kdf_CONTEXTBYTES + 1] = "ENWKkeys";
enum class SubKey : uint64_t { kCipher = 1, kFingerprint = 2 };

DataKey Derive(const DataKey& master, SubKey which) {
  std::array<uint8_t, DataKey::kBytes> out{};
  crypto_kdf_derive_from_key(out.data(), out.size(), static_cast<uint64_t>(which), kContext,
                             master.view().data());
  DataKey key{ByteView(out)};
  sodium_memzero(out.data(), out.size());
  return key;
}

Bytes HeadOf(const Uuid& person) {
  ByteWriter head;
  head.Raw(AsBytes({kMagic, sizeof kMagic}));
  head.U16(kVersion);
  head.U16(0);
  head.Raw(person.view());
  return head.Take();
}

}  // namespace

Bytes MasterKey::Wrap(const Uuid& person, const DataKey& key) const {
  Bytes out = HeadOf(person);
  out.resize(kWrappedBytes);
  uint8_t* const nonce = out.data() + kHeadBytes;
  randombytes_buf(nonce, kNonceBytes);
  const DataKey cipher = Derive(key_, SubKey::kCipher);
  unsigned long long size = 0;
  crypto_aead_xchacha20poly1305_ietf_encrypt(nonce + kNonceBytes, &size, key.view().data(),
                                             DataKey::kBytes, out.data(), kHeadBytes, nullptr,
                                             nonce, cipher.view().data());
  return out;
}

Result<DataKey> MasterKey::Unwrap(const Uuid& person, ByteView wrapped) const {
  const Bytes head = HeadOf(person);
  if (wrapped.size() != kWrappedBytes ||
      !std::equal(kMagic, kMagic + sizeof kMagic, wrapped.begin())) {
    return Status(Code::kStorage, "expected the wrapped key of person " + person.Text() +
                                      ", found " + std::to_string(wrapped.size()) +
                                      " bytes of something else; restore it from a backup");
  }
  const uint16_t version = ByteReader(wrapped.subspan(sizeof kMagic)).U16();
  if (version != kVersion) {
    return Status(Code::kVersion, "the wrapped key of person " + person.Text() + " has version " +
                                      std::to_string(version) + ", this enamel-server reads " +
                                      std::to_string(kVersion) + "; run the newer one");
  }
  const DataKey cipher = Derive(key_, SubKey::kCipher);
  const uint8_t* const nonce = wrapped.data() + kHeadBytes;
  std::array<uint8_t, DataKey::kBytes> plain{};
  unsigned long long size = 0;
  // Another person's key is not taken for this one's.
  if (!std::ranges::equal(wrapped.first(kHeadBytes), head) ||
      crypto_aead_xchacha20poly1305_ietf_decrypt(plain.data(), &size, nullptr, nonce + kNonceBytes,
                                                 DataKey::kBytes + kTagBytes, head.data(),
                                                 head.size(), nonce, cipher.view().data()) != 0) {
    return Status(Code::kStorage,
                  "the wrapped key of person " + person.Text() +
                      " is damaged or another's, or was wrapped with another master "
                      "key; compare the master key files, or restore a backup");
  }
  DataKey key{ByteView(plain)};
  sodium_memzero(plain.data(), plain.size());
  return key;
}

Sha256 MasterKey::Fingerprint() const {
  return HashSha256(Derive(key_, SubKey::kFingerprint).view());
}

Result<MasterKey> ReadMasterKey(const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes text, ReadPrivateFile(path, 1024, "the school's master key"));
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
