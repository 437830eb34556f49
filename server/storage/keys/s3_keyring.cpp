#include "server/storage/keys/s3_keyring.h"

#include <algorithm>
#include <set>

#include "server/storage/blobs/object_generation.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr size_t kUuidText = 36;

Status Erased(const Uuid& person) {
  return {Code::kConflict, "person " + person.Text() + " was erased"};
}

}  // namespace

S3Keyring::S3Keyring(std::unique_ptr<s3::S3Client> client, std::string prefix, MasterKey master,
                     Transactions& rows)
    : client_(std::move(client)),
      prefix_(std::move(prefix)),
      master_(std::move(master)),
      rows_(rows),
      trouble_("keys", [] { return NowMs(); }) {}

std::string S3Keyring::KeyOf(const Uuid& person, int64_t generation) const {
  return prefix_ + person.Text() + "-" + GenerationText(generation);
}

std::string S3Keyring::KeyOf(const Sha256& person) const {
  return prefix_ + "gone/" + person.Hex();
}

std::optional<Uuid> S3Keyring::PersonOf(const std::string& object) const {
  const std::string_view name = std::string_view(object).substr(prefix_.size());
  if (name.size() <= kUuidText || name[kUuidText] != '-') return {};
  const auto person = Uuid::Parse(name.substr(0, kUuidText));
  if (!person.ok() || !ReadGeneration(name.substr(kUuidText + 1))) return {};
  return *person;
}

Result<std::vector<s3::ListedObject>> S3Keyring::ListAll(const std::string& prefix) {
  std::vector<s3::ListedObject> out;
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->ListEach(prefix, [&](s3::ListedObject& object) {
    if (object.key.starts_with(prefix)) out.push_back(std::move(object));
  })));
  return out;
}

Result<std::optional<KeyRow>> S3Keyring::RowOf(const Uuid& person) {
  std::optional<KeyRow> row;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
    auto living = FindLivingKeyRow(db, person);
    if (living.ok()) row = *living;
    return living.status();
  }));
  return row;
}

void S3Keyring::Look() {
  if (trouble_.IsDue())
    (void)trouble_.Told(client_->Look(prefix_ + "look", S3Trouble::kLookWithin));
}

Result<DataKey> S3Keyring::Find(const Uuid& person) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, RowOf(person));
  if (!row) {
    MutexLock lock(mutex_);
    found_.erase(person);
    return Status(Code::kNotFound, "there is no key for person " + person.Text());
  }
  if (const auto held = FindHeld(*row)) return *held;
  MutexLock getting(GettingOf(person));
  return Get(*row);
}

std::optional<DataKey> S3Keyring::FindHeld(const KeyRow& row) {
  MutexLock lock(mutex_);
  const auto held = found_.find(row.person);
  if (held == found_.end()) return {};
  if (held->second.generation == row.generation) return held->second.key;
  // Erased by another server, and an erasure was taken back by restoring the database.
  found_.erase(held);
  return {};
}

Result<DataKey> S3Keyring::Get(const KeyRow& row) {
  if (const auto held = FindHeld(row)) return *held;
  const std::string object = KeyOf(row.person, row.generation);
  auto wrapped = client_->Get(object, row.hash, MasterKey::kWrappedBytes);
  if (wrapped.status().code() == Code::kNotFound) {
    // An erasure that is under way: its row goes last.
    ENAMEL_ASSIGN_OR_RETURN(const bool gone, IsGone(row.person));
    if (gone) return Status(Code::kNotFound, "person " + row.person.Text() + " was erased");
    return trouble_.Told(Status(
        Code::kStorage,
        "the object " + object + " is lost at " + client_->Where() + "; restore it from a backup"));
  }
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(wrapped.status()));
  ENAMEL_ASSIGN_OR_RETURN(const DataKey key, master_.Unwrap(row.person, *wrapped));
  Hold(row.person, {key, row.generation});
  return key;
}

void S3Keyring::Hold(const Uuid& person, const Remembered& held) {
  MutexLock lock(mutex_);
  if (found_.size() >= kMaxHeld) found_.clear();
  found_[person] = held;
}

std::optional<Keyring::Remembered> S3Keyring::Remember(const Uuid& person) {
  MutexLock lock(mutex_);
  const auto held = found_.find(person);
  if (held == found_.end()) return {};
  return held->second;
}

Result<DataKey> S3Keyring::FindOrMake(const Uuid& person) {
  auto key = Find(person);
  if (key.ok() || key.status().code() != Code::kNotFound) return key;
  MutexLock getting(GettingOf(person));
  ENAMEL_ASSIGN_OR_RETURN(auto row, RowOf(person));
  if (!row) {
    ENAMEL_RETURN_IF_ERROR(Add(person, DataKey::New()));
    ENAMEL_ASSIGN_OR_RETURN(row, RowOf(person));
  }
  if (!row) return Erased(person);  // since
  key = Get(*row);
  return key.status().code() == Code::kNotFound ? Erased(person) : key;
}

Status S3Keyring::Put(const Uuid& person, const DataKey& key) {
  const auto found = Find(person);
  if (found.ok() || found.status().code() != Code::kNotFound) return found.status();
  ENAMEL_RETURN_IF_ERROR(Add(person, key));
  // A key put here is read back from the bucket.
  MutexLock lock(mutex_);
  found_.erase(person);
  return Status::Ok();
}

Result<std::vector<Uuid>> S3Keyring::People() {
  std::vector<Uuid> out;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, AllKeyRows(db));
    out.clear();
    for (const KeyRow& row : rows) {
      ENAMEL_ASSIGN_OR_RETURN(const bool erased, IsErased(db, TombstoneOf(row.person)));
      if (!erased) out.push_back(row.person);
    }
    return Status::Ok();
  }));
  std::ranges::sort(out);
  return out;
}

Status S3Keyring::Add(const Uuid& person, const DataKey& key) {
  // A new key for somebody who was erased would let recordings in again.
  ENAMEL_ASSIGN_OR_RETURN(const bool gone, IsGone(person));
  if (gone) return Erased(person);
  const Bytes wrapped = master_.Wrap(person, key);
  const KeyRow mine{person, NewGeneration(), HashSha256(wrapped)};
  const std::string object = KeyOf(person, mine.generation);
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Put(object, wrapped)));
  bool counts = false;
  const Status added = rows_.Write([&](sql::Db& db) -> Status {
    counts = false;
    ENAMEL_ASSIGN_OR_RETURN(const bool is_erased, IsErased(db, TombstoneOf(person)));
    if (is_erased) return Erased(person);
    ENAMEL_RETURN_IF_ERROR(AddKeyRow(db, mine, NowMs()));
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindKeyRow(db, person));
    counts = row && row->generation == mine.generation;
    return Status::Ok();
  });
  // In doubt, the row may be there: then the object has to stay.
  if (added.ok() ? !counts : added.field() != "in_doubt") (void)client_->Delete(object);
  if (added.ok() && counts) Hold(person, {key, mine.generation});
  return added;
}

Status S3Keyring::Mark(const Sha256& person) {
  return trouble_.Told(client_->Put(KeyOf(person), {}));
}

Status S3Keyring::DestroyKeys(const Uuid& person, const std::vector<std::string>& objects) {
  for (const std::string& object : objects) {
    ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Delete(object)));
  }
  ENAMEL_RETURN_IF_ERROR(rows_.Write([&](sql::Db& db) { return DeleteKeyRow(db, person); }));
  MutexLock lock(mutex_);
  found_.erase(person);
  return Status::Ok();
}

Status S3Keyring::Destroy(const Uuid& person, int64_t now_ms) {
  const Tombstone tombstone{TombstoneOf(person), now_ms};
  std::optional<KeyRow> row;
  // In one transaction: it and another server's that makes a key at the same time cannot both be
  // kept.
  const Status marked = rows_.Write([&](sql::Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(AddErasure(db, tombstone));
    ENAMEL_ASSIGN_OR_RETURN(row, FindKeyRow(db, person));
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(marked);
  ENAMEL_RETURN_IF_ERROR(Mark(tombstone.person));
  ENAMEL_ASSIGN_OR_RETURN(const auto listed, ListAll(prefix_ + person.Text() + "-"));
  std::vector<std::string> objects;
  // A list may be older than the key.
  if (row) objects.push_back(KeyOf(person, row->generation));
  for (const s3::ListedObject& object : listed) objects.push_back(object.key);
  return DestroyKeys(person, objects);
}

Result<bool> S3Keyring::IsGone(const Uuid& person) {
  bool gone = false;
  const Status read = rows_.Read([&](sql::Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(gone, IsErased(db, TombstoneOf(person)));
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(read);
  return gone;
}

Result<Tombstone> S3Keyring::TombstoneIn(const s3::ListedObject& object) const {
  const std::string_view name = std::string_view(object.key).substr(KeyOf(Sha256()).size() - 64);
  const auto person = Sha256::FromHex(name);
  if (person.ok() && KeyOf(*person) == object.key) return Tombstone{*person, object.modified_ms};
  return Status(Code::kInvalidInput, object.key +
                                         " does not belong in a bucket of keys "
                                         "(schemas/personal_data.md); move it away");
}

Result<std::vector<Tombstone>> S3Keyring::Gone() {
  ENAMEL_ASSIGN_OR_RETURN(const auto listed, ListAll(prefix_ + "gone/"));
  std::vector<Tombstone> out;
  for (const s3::ListedObject& object : listed) {
    ENAMEL_ASSIGN_OR_RETURN(const Tombstone tombstone, TombstoneIn(object));
    out.push_back(tombstone);
  }
  return out;
}

Status S3Keyring::Bury(const std::vector<Tombstone>& tombstones) {
  std::map<Sha256, Tombstone> gone;
  for (const Tombstone& tombstone : tombstones) gone.emplace(tombstone.person, tombstone);
  // What the bucket knows of and the database does not: it was restored.
  std::set<Sha256> known;
  std::map<Uuid, std::vector<std::string>> keys;  // the objects of each, of the erased
  const Status read = rows_.Read([&](sql::Db& db) -> Status {
    known.clear();
    keys.clear();
    ENAMEL_ASSIGN_OR_RETURN(const auto erasures, ErasuresIn(db));
    for (const Tombstone& tombstone : erasures) known.insert(tombstone.person);
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, AllKeyRows(db));
    for (const KeyRow& row : rows) {
      if (gone.contains(TombstoneOf(row.person)))
        keys[row.person].push_back(KeyOf(row.person, row.generation));
    }
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(read);
  for (const auto& [person, tombstone] : gone) {
    if (known.contains(person)) continue;
    ENAMEL_RETURN_IF_ERROR(
        rows_.Write([&tombstone = tombstone](sql::Db& db) { return AddErasure(db, tombstone); }));
  }
  // A restored bucket has keys of the erased again.
  std::set<Sha256> marked;
  ENAMEL_ASSIGN_OR_RETURN(const auto listed, ListAll(prefix_));
  for (const s3::ListedObject& object : listed) {
    const auto person = PersonOf(object.key);
    if (person && gone.contains(TombstoneOf(*person))) keys[*person].push_back(object.key);
    const auto tombstone = TombstoneIn(object);
    if (tombstone.ok()) marked.insert(tombstone->person);
  }
  for (const auto& [person, tombstone] : gone) {
    if (!marked.contains(person)) ENAMEL_RETURN_IF_ERROR(Mark(person));
  }
  for (const auto& [person, objects] : keys) {
    ENAMEL_RETURN_IF_ERROR(DestroyKeys(person, objects));
  }
  return Status::Ok();
}

}  // namespace enamel::server
