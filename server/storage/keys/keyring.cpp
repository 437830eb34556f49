#include "server/storage/keys/keyring.h"

#include <sodium.h>

#include <algorithm>
#include <array>

#include "server/storage/keys/envelope.h"

namespace enamel::server {
namespace {

constexpr std::string_view kMagic = "ENEV";
constexpr uint16_t kVersion = 1;
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
    if (!key.ok()) return key.status();
    const Status put = keyring.Put(person, *key);
    // Only `keyring` knows that this one was erased.
    if (!put.ok() && put.code() != Code::kConflict) return put;
  }
  return Status::Ok();
}

Sha256 TombstoneOf(const Uuid& person) { return HashSha256(person.view()); }

Bytes SealPersonal(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data) {
  return SealEnvelope({kMagic, kVersion, person}, Derive(key, SubKey::kCipher),
                      NonceOf(key, attempt, data), data);
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
  if (head->version != kVersion) {
    return Status(Code::kVersion, "personal data of version " + std::to_string(head->version) +
                                      ", this enamel-server reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  const Uuid& person = head->person;
  if (!last_ || last_->first != person) {
    auto key = keyring_.Find(person);
    if (key.status().code() == Code::kNotFound) {
      return Status(Code::kNotFound,
                    "the key of person " + person.Text() +
                        " does not exist (any more): what was kept under it cannot be read");
    }
    if (!key.ok()) return key.status();
    last_.emplace(person, *key);
  }
  auto out = OpenEnvelope(bytes, Derive(last_->second, SubKey::kCipher));
  if (out) return std::move(*out);
  return Status(Code::kStorage, "personal data of person " + person.Text() +
                                    " is damaged, or was kept under another key; restore it and "
                                    "the key ring from a backup");
}

Result<bool> IsOfAttempt(Keyring& keyring, const Bytes& sealed, const Uuid& attempt) {
  const auto person = PersonOfSealed(sealed);
  if (!person) return Status(Code::kInvalidInput, "expected personal data, found other bytes");
  ENAMEL_ASSIGN_OR_RETURN(const Bytes data, OpenPersonal(keyring, sealed));
  ENAMEL_ASSIGN_OR_RETURN(const DataKey key, keyring.Find(*person));
  const auto nonce = NonceOf(key, attempt, data);
  return std::equal(nonce.begin(), nonce.end(), sealed.begin() + kEnvelopeHead);
}

}  // namespace enamel::server
