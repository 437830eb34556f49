#include "server/storage/s3_keyring.h"

#include <charconv>
#include <optional>
#include <set>

#include "server/storage/object_generation.h"
#include "server/storage/sql/query.h"

namespace enamel::server::sqlite {
namespace {

constexpr size_t kHashDigits = 64;

std::string MapKey(const Uuid& id) { return std::string(AsText(id.view())); }

}  // namespace

S3Keyring::S3Keyring(std::unique_ptr<s3::S3Client> client, std::string prefix, MasterKey master,
                     Transactions rows)
    : client_(std::move(client)),
      prefix_(std::move(prefix)),
      master_(std::move(master)),
      rows_(std::move(rows)),
      trouble_("keys", [] { return NowMs(); }) {}

std::string S3Keyring::KeyOf(const Uuid& person, int64_t generation) const {
  return prefix_ + person.Text() + "-" + GenerationText(generation);
}

std::string S3Keyring::KeyOf(const Tombstone& tombstone) const {
  return prefix_ + "gone/" + tombstone.person.Hex() + "-" + std::to_string(tombstone.erased_ms);
}

Result<std::optional<KeyRow>> S3Keyring::LivingRow(const Uuid& person) {
  std::optional<KeyRow> row;
  const Status read = rows_.read([&](sql::Db& db) -> Status {
    // An erasure that broke off has left the row, and the object perhaps.
    ENAMEL_ASSIGN_OR_RETURN(const bool erased, IsErased(db, TombstoneOf(person)));
    row.reset();
    if (erased) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(row, FindKeyRow(db, person));
    return Status::Ok();
  });
  if (!read.ok()) return read;
  return row;
}

Result<DataKey> S3Keyring::Find(const Uuid& person) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, LivingRow(person));
  {
    MutexLock lock(mutex_);
    const auto held = found_.find(MapKey(person));
    if (held != found_.end() && row && held->second.generation == row->generation) {
      return held->second.key;
    }
    // Erased by another server, or an erasure was taken back by restoring the database.
    if (held != found_.end()) found_.erase(held);
  }
  if (!row) return Status(Code::kNotFound, "there is no key for person " + person.Text());
  const std::string object = KeyOf(person, row->generation);
  auto wrapped = client_->Get(object, row->hash);
  if (wrapped.status().code() == Code::kNotFound) {
    // An erasure that is under way: its row goes last.
    ENAMEL_ASSIGN_OR_RETURN(const bool gone, IsGone(person));
    if (gone) return Status(Code::kNotFound, "person " + person.Text() + " was erased");
    return trouble_.Told(Status(
        Code::kStorage,
        "the object " + object + " is lost at " + client_->Where() + "; restore it from a backup"));
  }
  if (Status told = trouble_.Told(wrapped.status()); !told.ok()) return told;
  ENAMEL_ASSIGN_OR_RETURN(const DataKey key, master_.Unwrap(person, *wrapped));
  MutexLock lock(mutex_);
  if (found_.size() >= kMaxHeld) found_.clear();
  found_[MapKey(person)] = {row->generation, key};
  return key;
}

Result<DataKey> S3Keyring::FindOrMake(const Uuid& person) {
  auto key = Find(person);
  if (key.ok() || key.status().code() != Code::kNotFound) return key;
  // A new key for somebody who was erased would let recordings in again.
  const Status erased(Code::kConflict, "person " + person.Text() + " was erased");
  ENAMEL_ASSIGN_OR_RETURN(const bool gone, IsGone(person));
  if (gone) return erased;
  const Bytes wrapped = master_.Wrap(person, DataKey::New());
  const KeyRow mine{person, NewGeneration(), HashSha256(wrapped)};
  const std::string object = KeyOf(person, mine.generation);
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Put(object, wrapped)));
  bool counts = false;
  // When this fails, the row may have been added all the same: the object stays.
  const Status added = rows_.write([&](sql::Db& db) -> Status {
    counts = false;
    ENAMEL_ASSIGN_OR_RETURN(const bool is_erased, IsErased(db, TombstoneOf(person)));
    if (is_erased) return erased;
    ENAMEL_RETURN_IF_ERROR(AddKeyRow(db, mine, NowMs()));
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindKeyRow(db, person));
    counts = row && row->generation == mine.generation;
    return Status::Ok();
  });
  if (added.ok() ? !counts : added.code() == Code::kConflict) (void)client_->Delete(object);
  if (!added.ok()) return added;
  return Find(person);
}

Status S3Keyring::Mark(const Tombstone& tombstone) {
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Put(KeyOf(tombstone), {})));
  return rows_.write([&](sql::Db& db) { return AddErasure(db, tombstone); });
}

Status S3Keyring::DestroyKey(const Uuid& person) {
  std::optional<KeyRow> row;
  ENAMEL_RETURN_IF_ERROR(rows_.read([&](sql::Db& db) -> Status {
    auto found = FindKeyRow(db, person);
    if (found.ok()) row = *found;
    return found.status();
  }));
  if (row) {
    ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Delete(KeyOf(person, row->generation))));
    ENAMEL_RETURN_IF_ERROR(rows_.write([&](sql::Db& db) { return DeleteKeyRow(db, person); }));
  }
  MutexLock lock(mutex_);
  found_.erase(MapKey(person));
  return Status::Ok();
}

Status S3Keyring::Destroy(const Uuid& person, int64_t now_ms) {
  ENAMEL_RETURN_IF_ERROR(Mark({TombstoneOf(person), now_ms}));
  return DestroyKey(person);
}

Result<bool> S3Keyring::IsGone(const Uuid& person) {
  bool gone = false;
  const Status read = rows_.read([&](sql::Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(gone, IsErased(db, TombstoneOf(person)));
    return Status::Ok();
  });
  if (!read.ok()) return read;
  return gone;
}

Result<std::vector<Tombstone>> S3Keyring::Gone() {
  const std::string folder = prefix_ + "gone/";
  std::vector<Tombstone> out;
  std::string next;
  do {
    auto page = client_->List(folder, next);
    if (Status told = trouble_.Told(page.status()); !told.ok()) return told;
    for (const s3::ListedObject& object : page->objects) {
      const std::string_view name = std::string_view(object.key).substr(folder.size());
      const auto person = Sha256::FromHex(name.substr(0, kHashDigits));
      Tombstone tombstone;
      if (person.ok() && name.size() > kHashDigits + 1) {
        tombstone.person = *person;
        (void)std::from_chars(name.data() + kHashDigits + 1, name.data() + name.size(),
                              tombstone.erased_ms);
      }
      if (KeyOf(tombstone) != object.key) {
        return Status(Code::kInvalidInput, object.key +
                                               " does not belong in a bucket of keys "
                                               "(schemas/personal_data.md); move it away");
      }
      out.push_back(tombstone);
    }
    // A store that gives the same page again would be listed for ever.
    if (page->next == next) break;
    next = page->next;
  } while (!next.empty());
  return out;
}

Status S3Keyring::Bury(const std::vector<Tombstone>& tombstones) {
  ENAMEL_ASSIGN_OR_RETURN(const auto there, Gone());
  std::set<Sha256> marked, gone;
  for (const Tombstone& tombstone : there) marked.insert(tombstone.person);
  for (const Tombstone& tombstone : tombstones) {
    gone.insert(tombstone.person);
    if (!marked.contains(tombstone.person)) ENAMEL_RETURN_IF_ERROR(Mark(tombstone));
  }
  std::vector<KeyRow> rows;
  const Status written = rows_.write([&](sql::Db& db) -> Status {
    // What the bucket knows of and the database does not: it was restored.
    for (const Tombstone& tombstone : tombstones) {
      ENAMEL_RETURN_IF_ERROR(AddErasure(db, tombstone));
    }
    ENAMEL_ASSIGN_OR_RETURN(rows, AllKeyRows(db));
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(written);
  for (const KeyRow& row : rows) {
    if (gone.contains(TombstoneOf(row.person))) ENAMEL_RETURN_IF_ERROR(DestroyKey(row.person));
  }
  return Status::Ok();
}

}  // namespace enamel::server::sqlite
