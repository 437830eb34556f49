#include "server/storage/keys/keyring.h"

#include <sodium.h>

#include <algorithm>
#include <array>

#include "common/base/packed.h"
#include "server/storage/keys/envelope.h"

namespace enamel::server {
namespace {

constexpr std::string_view kMagic = "ENEV";
constexpr uint16_t kVersion = 1;
constexpr uint16_t kAsItIs = 0, kPacked = 1;  // flags
constexpr uint32_t kMaxPacked = 1u << 30;
// Sub-keys of a person's key (schemas/personal_data.md).
constexpr char kContext[] = "ENEVkeys";
enum class SubKey : uint64_t { kCipher = 1, kNonce = 2 };

DataKey Derive(const DataKey& key, SubKey which) {
  return key.Derive(kContext, static_cast<uint64_t>(which));
}

// From key and content instead of at random: the same content gives the same bytes, so a trace
// that is written again after a crash is the same blob; and no two contents share a nonce but by
// a collision of 192 bits.
std::array<uint8_t, kEnvelopeNonce> NonceOf(const DataKey& key, const Uuid& attempt,
                                            ByteView data) {
  std::array<uint8_t, kEnvelopeNonce> nonce{};
  const DataKey nonce_key = Derive(key, SubKey::kNonce);
  crypto_generichash_state state;
  crypto_generichash_init(&state, nonce_key.view().data(), nonce_key.view().size(), nonce.size());
  crypto_generichash_update(&state, attempt.bytes.data(), attempt.bytes.size());
  crypto_generichash_update(&state, data.data(), data.size());
  crypto_generichash_final(&state, nonce.data(), nonce.size());
  return nonce;
}

Bytes Seal(const Uuid& person, const DataKey& key, const Uuid& attempt, uint16_t flags,
           ByteView content) {
  return SealEnvelope({kMagic, kVersion, person, flags}, Derive(key, SubKey::kCipher),
                      NonceOf(key, attempt, content), content);
}

Result<DataKey> KeyOf(Keyring& keyring, const Uuid& person) {
  auto key = keyring.Find(person);
  if (key.status().code() != Code::kNotFound) return key;
  return Status(Code::kNotFound,
                "the key of person " + person.Text() +
                    " does not exist (any more): what was kept under it cannot be read");
}

Status Damaged(const Uuid& person) {
  return Status(Code::kStorage, "personal data of person " + person.Text() +
                                    " is damaged, or was kept under another key; restore it and "
                                    "the key ring from a backup");
}

// Packed as it may be. Requires: HeadOfEnvelope(sealed, kMagic).
Result<Bytes> ContentOf(const Uuid& person, const DataKey& key, ByteView sealed) {
  auto out = OpenEnvelope(sealed, Derive(key, SubKey::kCipher));
  if (!out) return Damaged(person);
  return std::move(*out);
}

}  // namespace

Status Join(Keyring& keyring, Keyring& other,
            const std::function<void(uint64_t, uint64_t)>& progress) {
  ENAMEL_ASSIGN_OR_RETURN(const auto gone, other.Gone());
  // First, so that no key destroyed elsewhere is added.
  ENAMEL_RETURN_IF_ERROR(keyring.Bury(gone));
  ENAMEL_ASSIGN_OR_RETURN(const auto people, other.People());
  uint64_t done = 0;
  for (const Uuid& person : people) {
    if (progress) progress(++done, people.size());
    const auto key = other.Find(person);
    if (key.status().code() == Code::kNotFound) continue;  // erased meanwhile
    ENAMEL_RETURN_IF_ERROR(key.status());
    const Status put = keyring.Put(person, *key);
    // Only `keyring` knows that this one was erased.
    if (!put.ok() && put.code() != Code::kConflict) return put;
  }
  return Status::Ok();
}

Sha256 TombstoneOf(const Uuid& person) { return HashSha256(person.view()); }

Bytes SealPersonal(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data) {
  return Seal(person, key, attempt, kAsItIs, data);
}

Bytes SealPacked(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data) {
  ENAMEL_CHECK(data.size() <= kMaxPacked);
  ByteWriter packed;
  packed.U32(static_cast<uint32_t>(data.size()));
  packed.Raw(Pack(data, kTextLevel));
  return Seal(person, key, attempt, kPacked, packed.bytes());
}

std::optional<Uuid> PersonOfSealed(ByteView bytes) {
  const auto head = HeadOfEnvelope(bytes, kMagic);
  if (!head) return {};
  return head->person;
}

Result<Bytes> OpenPersonal(Keyring& keyring, Bytes bytes) {
  return PersonalReader(keyring).Open(std::move(bytes));
}

Result<Bytes> PersonalReader::Open(Bytes bytes) {
  const auto head = HeadOfEnvelope(bytes, kMagic);
  if (!head) return bytes;
  if (head->version != kVersion || head->flags > kPacked) {
    return Status(Code::kVersion, "personal data of version " + std::to_string(head->version) +
                                      " and flags " + std::to_string(head->flags) +
                                      ", this enamel-server reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  if (!last_ || last_->first != head->person) {
    ENAMEL_ASSIGN_OR_RETURN(const DataKey key, KeyOf(keyring_, head->person));
    last_.emplace(head->person, key);
  }
  ENAMEL_ASSIGN_OR_RETURN(Bytes content, ContentOf(head->person, last_->second, bytes));
  if (head->flags == kAsItIs) return content;
  ByteReader in(content);
  const uint32_t size = in.U32();
  if (!in.ok() || size > kMaxPacked) return Damaged(head->person);
  return Unpack(ByteView(content).subspan(in.offset()), size, "personal data");
}

Result<bool> IsOfAttempt(Keyring& keyring, const Bytes& sealed, const Uuid& attempt) {
  const auto person = PersonOfSealed(sealed);
  if (!person) return Status(Code::kInvalidInput, "expected personal data, found other bytes");
  ENAMEL_ASSIGN_OR_RETURN(const DataKey key, KeyOf(keyring, *person));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes content, ContentOf(*person, key, sealed));
  const auto nonce = NonceOf(key, attempt, content);
  return std::equal(nonce.begin(), nonce.end(), sealed.begin() + kEnvelopeHead);
}

}  // namespace enamel::server
