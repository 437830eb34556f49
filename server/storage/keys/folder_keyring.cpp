#include "server/storage/keys/folder_keyring.h"

#include <sodium.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "common/base/file.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

// Keys held in memory; with more people than that recording at once, files are read again.
constexpr size_t kMaxHeld = 50'000;

std::string MapKey(const Uuid& id) { return std::string(AsText(id.view())); }

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

// The leftover of a crash in WriteFileDurably.
bool IsLeftover(const fs::path& path) {
  return path.filename().string().find(".tmp") != std::string::npos;
}

}  // namespace

fs::path FolderKeyring::KeyPath(const Uuid& person) const {
  return folder_ / (person.Text() + ".key");
}

fs::path FolderKeyring::GonePath(const Sha256& person) const {
  return folder_ / "gone" / person.Hex();
}

bool FolderKeyring::HasTombstone(const Uuid& person) const {
  std::error_code error;
  return fs::exists(GonePath(TombstoneOf(person)), error);
}

Result<bool> FolderKeyring::IsGone(const Uuid& person) { return HasTombstone(person); }

Result<DataKey> FolderKeyring::Read(const Uuid& person) const {
  auto bytes = ReadFile(KeyPath(person), 1024);
  if (!bytes.ok() && bytes.status().code() == Code::kNotFound) {
    return Status(Code::kNotFound, "there is no key for person " + person.Text());
  }
  ENAMEL_RETURN_IF_ERROR(bytes.status());
  if (bytes->size() != DataKey::kBytes) {
    return Status(Code::kStorage, KeyPath(person).string() + " has " +
                                      std::to_string(bytes->size()) +
                                      " bytes, a key has 32; restore it from a backup");
  }
  DataKey key{ByteView(*bytes)};
  sodium_memzero(bytes->data(), bytes->size());
  return key;
}

Result<DataKey> FolderKeyring::Find(const Uuid& person) {
  MutexLock lock(mutex_);
  auto held = found_.find(MapKey(person));
  if (held != found_.end()) {
    // Another process may have erased the person meanwhile.
    if (!HasTombstone(person)) return held->second;
    found_.erase(held);
  }
  auto key = Read(person);
  ENAMEL_RETURN_IF_ERROR(key.status());
  if (found_.size() >= kMaxHeld) found_.clear();
  found_[MapKey(person)] = *key;
  return key;
}

Result<DataKey> FolderKeyring::FindOrMake(const Uuid& person) {
  auto key = Find(person);
  if (key.ok() || key.status().code() != Code::kNotFound) return key;
  MutexLock lock(mutex_);
  key = Read(person);  // another thread may have been faster
  if (!key.ok() && key.status().code() == Code::kNotFound) {
    // A new key for somebody who was erased would let recordings in again.
    if (HasTombstone(person)) {
      return Status(Code::kConflict, "person " + person.Text() + " was erased");
    }
    key = DataKey::New();
    ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_));
    ENAMEL_RETURN_IF_ERROR(disk_.Replace(KeyPath(person), key->view()));
  }
  if (key.ok()) found_[MapKey(person)] = *key;
  return key;
}

Status FolderKeyring::Put(const Uuid& person, const DataKey& key) {
  MutexLock lock(mutex_);
  if (HasTombstone(person)) {
    return Status(Code::kConflict, "person " + person.Text() + " was erased");
  }
  std::error_code error;
  if (fs::exists(KeyPath(person), error)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_));
  return disk_.Replace(KeyPath(person), key.view());
}

Status FolderKeyring::Mark(const Tombstone& tombstone) {
  std::error_code error;
  if (fs::exists(GonePath(tombstone.person), error)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_ / "gone"));
  return disk_.Replace(GonePath(tombstone.person),
                       AsBytes(std::to_string(tombstone.erased_ms) + "\n"));
}

Status FolderKeyring::Destroy(const Uuid& person, int64_t now_ms) {
  // Before the key: a crash in between leaves a mark, and the next start shreds the key.
  ENAMEL_RETURN_IF_ERROR(Mark({TombstoneOf(person), now_ms}));
  return disk_.Shred(KeyPath(person));
}

Status FolderKeyring::Bury(const std::vector<Tombstone>& tombstones) {
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

Result<std::vector<Uuid>> FolderKeyring::People() {
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

Result<std::vector<Tombstone>> FolderKeyring::Gone() {
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

Status FolderKeyring::MirrorFrom(Keyring& other) {
  ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(folder_));
  ENAMEL_RETURN_IF_ERROR(Join(*this, other));
  ENAMEL_ASSIGN_OR_RETURN(auto theirs, other.People());
  ENAMEL_ASSIGN_OR_RETURN(auto mine, People());
  for (const Uuid& person : mine) {
    if (!std::ranges::binary_search(theirs, person))
      ENAMEL_RETURN_IF_ERROR(disk_.Shred(KeyPath(person)));
  }
  return Status::Ok();
}

}  // namespace enamel::server
