#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/mutex.h"
#include "server/s3/s3_client.h"
#include "server/storage/blobs/s3_trouble.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/key_rows.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/keys/master_key.h"

namespace enamel::server {

// The key ring of several servers: objects of a bucket of its own (key_bucket.h),
//   PREFIX<uuid>-<generation, 16 hexadecimal digits>       a person's key, wrapped (master_key.h)
//   PREFIXgone/<sha256>                                    an erased person (Tombstone); empty
// and the table `person_keys` says which generation counts (schemas/sql/0001_initial.sql). Any S3
// store will do.
//
// * FindOrMake uploads a key of a new generation first. Then it adds the key's row, in one serial
//   transaction that checks whether another server was faster or the person is erased; if so, it
//   deletes its own object. A key is used only once its row is committed, so an object that a crash
//   leaves without a row opens nothing.
// * Find asks the database each time and the bucket once, even if many ask for one person's key at
//   the same moment: another server's erasure takes effect at once.
// * Destroy: the tombstone's row first (`erasures`), after which no server makes or finds the key;
//   then the tombstone's object, which a restored database is compared with; then every object of
//   the person's keys, including those that never counted or no longer do; their row last. After a
//   failure Bury finishes it, when a server starts, or within an hour if the bucket was unreachable
//   then.
// * A server keeps a key in memory until it is requested again, or the server ends. A chunk is
//   written with it only if the writing statement finds that its generation still counts
//   (Keyring::Remember).
//
// Errors also: kUnavailable (bucket or database unreachable). Failures of the store are reported as
// S3Trouble says. Thread safety: any thread.
class S3Keyring final : public Keyring {
 public:
  S3Keyring(std::unique_ptr<s3::S3Client> client, std::string prefix, MasterKey master,
            Transactions& rows);

  Result<DataKey> Find(const Uuid& person) override;
  Result<DataKey> FindOrMake(const Uuid& person) override;
  std::optional<Remembered> Remember(const Uuid& person) override;
  Status Destroy(const Uuid& person, int64_t now_ms) override;
  Result<bool> IsGone(const Uuid& person) override;
  // Those of the bucket.
  Result<std::vector<Tombstone>> Gone() override;
  // Of the living; the rows say who.
  Result<std::vector<Uuid>> People() override;
  Status Put(const Uuid& person, const DataKey& key) override;
  Status Bury(const std::vector<Tombstone>& tombstones) override;
  Status Problem() const override { return trouble_.Problem(); }
  void Look() override;
  std::optional<s3::S3Figures> Figures() const override { return client_->figures(); }

  std::string KeyOf(const Uuid& person, int64_t generation) const;
  // Of a tombstone.
  std::string KeyOf(const Sha256& person) const;

 private:
  // Keys held in memory; with more people than that recording at once, objects are read again.
  static constexpr size_t kMaxHeld = 50'000;
  // Of the living.
  Result<std::optional<KeyRow>> RowOf(const Uuid& person);
  std::optional<DataKey> FindHeld(const KeyRow& row);
  // From memory or the bucket. Its group of getting_ is held.
  Result<DataKey> Get(const KeyRow& row);
  void Hold(const Uuid& person, const Remembered& held);
  Mutex& GettingOf(const Uuid& person) { return getting_[person.bytes.back() % getting_.size()]; }
  // All objects whose key begins with `prefix`.
  Result<std::vector<s3::ListedObject>> ListAll(const std::string& prefix);
  // The person of an object's key; none: it is something else.
  std::optional<Uuid> PersonOf(const std::string& object) const;
  Result<Tombstone> TombstoneIn(const s3::ListedObject& object) const;
  Status Mark(const Sha256& person);
  // Uploads the key and adds its row, unless there is one.
  Status Add(const Uuid& person, const DataKey& key);
  // The objects and the row of an erased person's keys.
  Status DestroyKeys(const Uuid& person, const std::vector<std::string>& objects);

  const std::unique_ptr<s3::S3Client> client_;
  const std::string prefix_;
  const MasterKey master_;
  Transactions& rows_;
  S3Trouble trouble_;
  // Held while getting a key from the bucket or making one, so that others who want the same key
  // wait. One for each of a few groups of people.
  std::array<Mutex, 64> getting_;
  Mutex mutex_;
  std::map<Uuid, Remembered> found_ ENAMEL_GUARDED_BY(mutex_);  // by person
};

}  // namespace enamel::server
