#include "server/storage/keyring.h"

#include <sodium.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "common/base/file.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

constexpr size_t kKeyBytes = 32;
constexpr char kMagic[] = {'E', 'N', 'P', 'D'};
constexpr uint16_t kVersion = 1;
constexpr size_t kHeadBytes = 4 + 2 + 2 + 16;
constexpr size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
// Keys held in memory; with more people than that recording at once, files are read again.
constexpr size_t kMaxHeld = 50'000;
// Sub-keys of a person's key (schemas/personal_data.md).
constexpr char kContext[crypto_kdf_CONTEXTBYTES + 1] = "ENPDkeys";
enum class SubKey : uint64_t { kCipher = 1, kNonce = 2 };

static_assert(kKeyBytes == crypto_kdf_KEYBYTES);

std::string MapKey(const Uuid& id) { return std::string(AsText(id.view())); }

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

Status NotOurs(const fs::path& path) {
  return Status(Code::kInvalidInput,
                path.string() +
                    " does not belong in a key ring (schemas/personal_data.md); move "
                    "it away");
}

// Files of a folder in the order of their names; none when the folder is absent.
Result<std::vector<fs::path>> FilesOf(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  if (!fs::exists(folder, error)) return out;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error)) out.push_back(it->path());
  }
  if (error)
    return Status(Code::kStorage, "cannot read " + folder.string() + ": " + error.message());
  std::sort(out.begin(), out.end());
  return out;
}

// What a crash in WriteFileDurably leaves behind.
bool IsLeftover(const fs::path& path) {
  return path.filename().string().find(".tmp") != std::string::npos;
}

}  // namespace

DataKey::DataKey(ByteView bytes) {
  ENAMEL_CHECK(bytes.size() == kKeyBytes);
  std::ranges::copy(bytes, bytes_.begin());
}

DataKey::~DataKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

DataKey DataKey::New() {
  std::array<uint8_t, kKeyBytes> random{};
  randombytes_buf(random.data(), random.size());
  DataKey key{ByteView(random)};
  // The copy on the stack would outlive the key.
  sodium_memzero(random.data(), random.size());
  return key;
}

Sha256 TombstoneOf(const Uuid& person) { return HashSha256(person.view()); }

fs::path Keyring::KeyPath(const Uuid& person) const { return folder_ / (person.Text() + ".key"); }

fs::path Keyring::GonePath(const Sha256& person) const { return folder_ / "gone" / person.Hex(); }

bool Keyring::IsGone(const Uuid& person) const {
  std::error_code error;
  return fs::exists(GonePath(TombstoneOf(person)), error);
}

Result<DataKey> Keyring::Read(const Uuid& person) const {
  auto bytes = ReadFile(KeyPath(person), 1024);
  if (!bytes.ok() && bytes.status().code() == Code::kNotFound) {
    return Status(Code::kNotFound, "there is no key for person " + person.Text());
  }
  if (!bytes.ok()) return bytes.status();
  if (bytes->size() != kKeyBytes) {
    return Status(Code::kStorage, KeyPath(person).string() + " has " +
                                      std::to_string(bytes->size()) +
                                      " bytes, a key has 32; restore it from a backup");
  }
  DataKey key{ByteView(*bytes)};
  sodium_memzero(bytes->data(), bytes->size());
  return key;
}

Result<DataKey> Keyring::Find(const Uuid& person) {
  std::lock_guard lock(mutex_);
  auto held = found_.find(MapKey(person));
  if (held != found_.end()) {
    // Another process may have erased the person meanwhile.
    if (!IsGone(person)) return held->second;
    found_.erase(held);
  }
  auto key = Read(person);
  if (!key.ok()) return key;
  if (found_.size() >= kMaxHeld) found_.clear();
  found_[MapKey(person)] = *key;
  return key;
}

Result<DataKey> Keyring::FindOrMake(const Uuid& person) {
  auto key = Find(person);
  if (key.ok() || key.status().code() != Code::kNotFound) return key;
  std::lock_guard lock(mutex_);
  key = Read(person);  // another thread may have been faster
  if (!key.ok() && key.status().code() == Code::kNotFound) {
    // A new key for somebody who was erased would let recordings in again.
    if (IsGone(person)) {
      return Status(Code::kConflict, "person " + person.Text() + " was erased");
    }
    key = DataKey::New();
    ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_));
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(KeyPath(person), key->view()));
  }
  if (key.ok()) found_[MapKey(person)] = *key;
  return key;
}

Status Keyring::Mark(const Tombstone& tombstone) {
  std::error_code error;
  if (fs::exists(GonePath(tombstone.person), error)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_ / "gone"));
  return disk_.Replace(GonePath(tombstone.person),
                       AsBytes(std::to_string(tombstone.erased_ms) + "\n"));
}

Status Keyring::Destroy(const Uuid& person, int64_t now_ms) {
  // Before the key: a crash in between leaves a mark, and the next start shreds the key.
  ENAMEL_RETURN_IF_ERROR(Mark({TombstoneOf(person), now_ms}));
  return disk_.Shred(KeyPath(person));
}

Status Keyring::Bury(const std::vector<Tombstone>& tombstones) {
  std::set<Sha256> gone;
  for (const Tombstone& tombstone : tombstones) {
    ENAMEL_RETURN_IF_ERROR(Mark(tombstone));
    gone.insert(tombstone.person);
  }
  ENAMEL_ASSIGN_OR_RETURN(auto people, People());
  for (const Uuid& person : people) {
    if (gone.contains(TombstoneOf(person))) ENAMEL_RETURN_IF_ERROR(disk_.Shred(KeyPath(person)));
  }
  return Status::Ok();
}

Result<std::vector<Uuid>> Keyring::People() const {
  ENAMEL_ASSIGN_OR_RETURN(auto files, FilesOf(folder_));
  std::vector<Uuid> out;
  for (const fs::path& file : files) {
    if (IsLeftover(file)) continue;
    auto id = Uuid::Parse(file.stem().string());
    if (file.extension() != ".key" || !id.ok()) return NotOurs(file);
    out.push_back(*id);
  }
  return out;
}

Result<std::vector<Tombstone>> Keyring::Gone() const {
  ENAMEL_ASSIGN_OR_RETURN(auto files, FilesOf(folder_ / "gone"));
  std::vector<Tombstone> out;
  for (const fs::path& file : files) {
    if (IsLeftover(file)) continue;
    auto person = Sha256::FromHex(file.filename().string());
    ENAMEL_ASSIGN_OR_RETURN(auto text, ReadFile(file, 64));
    std::string_view digits = AsText(text);
    Tombstone tombstone;
    auto [end, bad] =
        std::from_chars(digits.data(), digits.data() + digits.size(), tombstone.erased_ms);
    if (!person.ok() || bad != std::errc()) return NotOurs(file);
    tombstone.person = *person;
    out.push_back(tombstone);
  }
  return out;
}

Status Keyring::Join(const Keyring& other) {
  ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_));
  ENAMEL_ASSIGN_OR_RETURN(auto gone, other.Gone());
  // First, so that no key comes in that was destroyed elsewhere.
  ENAMEL_RETURN_IF_ERROR(Bury(gone));
  ENAMEL_ASSIGN_OR_RETURN(auto theirs, other.People());
  ENAMEL_ASSIGN_OR_RETURN(auto mine, People());
  for (const Uuid& person : theirs) {
    if (std::ranges::binary_search(mine, person)) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto key, other.Read(person));
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(KeyPath(person), key.view()));
  }
  // Those that only this ring knows as erased may have come with the other's keys.
  ENAMEL_ASSIGN_OR_RETURN(auto all, Gone());
  return Bury(all);
}

Status Keyring::MirrorFrom(const Keyring& other) {
  ENAMEL_RETURN_IF_ERROR(Join(other));
  ENAMEL_ASSIGN_OR_RETURN(auto theirs, other.People());
  ENAMEL_ASSIGN_OR_RETURN(auto mine, People());
  for (const Uuid& person : mine) {
    if (!std::ranges::binary_search(theirs, person))
      ENAMEL_RETURN_IF_ERROR(disk_.Shred(KeyPath(person)));
  }
  return Status::Ok();
}

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
  auto person = PersonOfSealed(bytes);
  if (!person) return bytes;
  ByteReader head(ByteView(bytes).subspan(4));
  uint16_t version = head.U16();
  if (version != kVersion) {
    return Status(Code::kVersion, "personal data of version " + std::to_string(version) +
                                      ", this enamel-server reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  auto key = keyring.Find(*person);
  if (!key.ok() && key.status().code() == Code::kNotFound) {
    return Status(Code::kNotFound, "the key of person " + person->Text() +
                                       " does not exist (any more): what was kept under it cannot "
                                       "be read");
  }
  if (!key.ok()) return key.status();
  auto cipher_key = Derive(*key, SubKey::kCipher);
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
