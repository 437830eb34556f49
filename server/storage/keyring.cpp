#include "server/storage/keyring.h"

#include <sodium.h>

#include <algorithm>

namespace enamel::server {
namespace {

constexpr char kMagic[] = {'E', 'N', 'P', 'D'};
constexpr uint16_t kVersion = 1;
constexpr size_t kHeadBytes = 4 + 2 + 2 + 16;
constexpr size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
// Sub-keys of a person's key (schemas/personal_data.md).
constexpr char kContext[crypto_kdf_CONTEXTBYTES + 1] = "ENPDkeys";
enum class SubKey : uint64_t { kCipher = 1, kNonce = 2 };

static_assert(DataKey::kBytes == crypto_kdf_KEYBYTES);

std::array<uint8_t, 32> Derive(const DataKey& key, SubKey which) {
  std::array<uint8_t, 32> out{};
  crypto_kdf_derive_from_key(out.data(), out.size(), static_cast<uint64_t>(which), kContext,
                             key.view().data());
  return out;
}

Bytes HeadOf(const Uuid& person) {
  ByteWriter head;
  head.Raw(AsBytes({kMagic, sizeof kMagic}));
  head.U16(kVersion);
  head.U16(0);
  head.Raw(person.view());
  return head.Take();
}

// From key and content instead of at random: the same content gives the same bytes, so a trace
// that is written again after a crash is the same blob; and no two contents share a nonce but by
// a collision of 192 bits.
std::array<uint8_t, kNonceBytes> NonceOf(const DataKey& key, const Uuid& attempt, ByteView data) {
  std::array<uint8_t, kNonceBytes> nonce{};
  auto nonce_key = Derive(key, SubKey::kNonce);
  crypto_generichash_state state;
  crypto_generichash_init(&state, nonce_key.data(), nonce_key.size(), nonce.size());
  crypto_generichash_update(&state, attempt.bytes.data(), attempt.bytes.size());
  crypto_generichash_update(&state, data.data(), data.size());
  crypto_generichash_final(&state, nonce.data(), nonce.size());
  return nonce;
}

}  // namespace

DataKey::DataKey(ByteView bytes) {
  ENAMEL_CHECK(bytes.size() == DataKey::kBytes);
  std::ranges::copy(bytes, bytes_.begin());
}

DataKey::~DataKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

DataKey DataKey::New() {
  std::array<uint8_t, DataKey::kBytes> random{};
  randombytes_buf(random.data(), random.size());
  DataKey key{ByteView(random)};
  // The copy on the stack would outlive the key.
  sodium_memzero(random.data(), random.size());
  return key;
}

Sha256 TombstoneOf(const Uuid& person) { return HashSha256(person.view()); }

Bytes SealPersonal(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data) {
  Bytes out = HeadOf(person);
  auto nonce = NonceOf(key, attempt, data);
  auto cipher_key = Derive(key, SubKey::kCipher);
  out.insert(out.end(), nonce.begin(), nonce.end());
  out.resize(kHeadBytes + kNonceBytes + data.size() + kTagBytes);
  unsigned long long size = 0;
  crypto_aead_xchacha20poly1305_ietf_encrypt(out.data() + kHeadBytes + kNonceBytes, &size,
                                             data.data(), data.size(), out.data(), kHeadBytes,
                                             nullptr, nonce.data(), cipher_key.data());
  return out;
}

std::optional<Uuid> PersonOfSealed(ByteView bytes) {
  if (bytes.size() < kHeadBytes + kNonceBytes + kTagBytes ||
      AsText(bytes.first(sizeof kMagic)) != std::string_view(kMagic, sizeof kMagic)) {
    return std::nullopt;
  }
  return Uuid::FromBytes(bytes.subspan(8, 16));
}

Result<Bytes> OpenPersonal(Keyring& keyring, Bytes bytes) {
  return PersonalReader(keyring).Open(std::move(bytes));
}

Result<Bytes> PersonalReader::Open(Bytes bytes) {
  auto person = PersonOfSealed(bytes);
  if (!person) return bytes;
  ByteReader head(ByteView(bytes).subspan(4));
  uint16_t version = head.U16();
  if (version != kVersion) {
    return Status(Code::kVersion, "personal data of version " + std::to_string(version) +
                                      ", this enamel-server reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  if (!last_ || last_->first != *person) {
    auto key = keyring_.Find(*person);
    if (key.status().code() == Code::kNotFound) {
      return Status(Code::kNotFound,
                    "the key of person " + person->Text() +
                        " does not exist (any more): what was kept under it cannot "
                        "be read");
    }
    if (!key.ok()) return key.status();
    last_.emplace(*person, *key);
  }
  auto cipher_key = Derive(last_->second, SubKey::kCipher);
  Bytes out(bytes.size() - kHeadBytes - kNonceBytes - kTagBytes);
  unsigned long long size = 0;
  const uint8_t* nonce = bytes.data() + kHeadBytes;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(
          out.data(), &size, nullptr, nonce + kNonceBytes, bytes.size() - kHeadBytes - kNonceBytes,
          bytes.data(), kHeadBytes, nonce, cipher_key.data()) != 0) {
    return Status(Code::kStorage, "personal data of person " + person->Text() +
                                      " is damaged, or was kept under another key; restore it and "
                                      "the key ring from a backup");
  }
  return out;
}

Result<bool> IsOfAttempt(Keyring& keyring, const Bytes& sealed, const Uuid& attempt) {
  const auto person = PersonOfSealed(sealed);
  if (!person) return Status(Code::kInvalidInput, "expected personal data, found other bytes");
  ENAMEL_ASSIGN_OR_RETURN(const Bytes data, OpenPersonal(keyring, sealed));
  ENAMEL_ASSIGN_OR_RETURN(const DataKey key, keyring.Find(*person));
  const auto nonce = NonceOf(key, attempt, data);
  return std::equal(nonce.begin(), nonce.end(), sealed.begin() + kHeadBytes);
}

}  // namespace enamel::server
