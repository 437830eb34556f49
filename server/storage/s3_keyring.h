#pragma once

#include <functional>
#include <memory>
#include <string>
#include <unordered_map>

#include "common/base/mutex.h"
#include "common/s3/s3_client.h"
#include "server/storage/keyring.h"
#include "server/storage/master_key.h"
#include "server/storage/s3_trouble.h"
#include "server/storage/sql/key_rows.h"
#include "server/storage/transactions.h"

namespace enamel::server::sqlite {

// The key ring of several servers: objects of a bucket of its own (key_bucket.h),
//   PREFIX<uuid>-<generation, 16 hexadecimal digits>       a person's key, wrapped (master_key.h)
//   PREFIXgone/<sha256>-<milliseconds since 1970>          an erased person (Tombstone); empty
// and the table `person_keys` says which generation counts (schemas/sql/0020_keys.sql). Of S3 no more is
// asked than every store does.
//
// * FindOrMake uploads a key of a new generation first and adds its row then, in one serial transaction
//   with the look whether another server was faster or the person is erased; then its own object goes.
//   A key is used once its row is kept, so an object that a crash leaves without a row opens nothing.
// * Find asks the database each time and the bucket once: another server's erasure counts at once.
// * Destroy: the tombstone's object first, then its row (`erasures`), after which no server makes or
//   finds the key; then the key's object; its row last, so that a crash in between leaves the row by
//   which Bury finds the object.
//
// Errors also: kUnavailable (bucket or database is away). What fails of the store is told as S3Trouble
// does. Thread safety: any thread.
class S3Keyring final : public Keyring {
 public:
  S3Keyring(std::unique_ptr<s3::S3Client> client, std::string prefix, MasterKey master,
            Transactions rows);

  Result<DataKey> Find(const Uuid& person) override;
  Result<DataKey> FindOrMake(const Uuid& person) override;
  Status Destroy(const Uuid& person, int64_t now_ms) override;
  Result<bool> IsGone(const Uuid& person) override;
  // Those of the bucket.
  Result<std::vector<Tombstone>> Gone() override;
  Status Bury(const std::vector<Tombstone>& tombstones) override;
  Status Problem() const override { return trouble_.Problem(); }

  std::string KeyOf(const Uuid& person, int64_t generation) const;
  std::string KeyOf(const Tombstone& tombstone) const;

 private:
  // Keys held in memory; with more people than that recording at once, objects are read again.
  static constexpr size_t kMaxHeld = 50'000;
  struct Held {
    int64_t generation = 0;
    DataKey key;
  };
  // None: never had a key, or erased.
  Result<std::optional<KeyRow>> LivingRow(const Uuid& person);
  Status Mark(const Tombstone& tombstone);
  // Of an erased person.
  Status DestroyKey(const Uuid& person);

  const std::unique_ptr<s3::S3Client> client_;
  const std::string prefix_;
  const MasterKey master_;
  const Transactions rows_;
  S3Trouble trouble_;
  Mutex mutex_;
  std::unordered_map<std::string, Held> found_ ENAMEL_GUARDED_BY(mutex_);  // by id bytes
};

}  // namespace enamel::server::sqlite
