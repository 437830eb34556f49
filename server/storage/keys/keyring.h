#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/s3/s3_figures.h"
#include "server/storage/keys/data_key.h"

namespace enamel::server {

// The person in the list of erasures: enough to recognise an id that turns up again, not to find
// one.
Sha256 TombstoneOf(const Uuid& person);

struct Tombstone {
  Sha256 person;
  int64_t erased_ms = 0;
};

// The keys of people, and the list of the erased (schemas/personal_data.md). Kept apart from the
// database and the blobs, so that destroying a key makes its data unreadable in every copy of
// those. Thread safety: any thread.
class Keyring {
 public:
  virtual ~Keyring() = default;

  // Errors: kNotFound (never had one, or erased).
  virtual Result<DataKey> Find(const Uuid& person) = 0;
  // Made, and durable, when there is none. Errors: kConflict (erased), kStorage.
  virtual Result<DataKey> FindOrMake(const Uuid& person) = 0;
  // A key that this process has in memory, without a look whether it still counts. Of a key ring of
  // several servers it does while the person's row of `person_keys` is of this generation; who
  // writes with it asks that in the same statement (AppendChunk), which saves the look. None: none
  // in memory, or a key ring that others do not change.
  struct Remembered {
    DataKey key;
    int64_t generation = 0;
  };
  virtual std::optional<Remembered> Remember(const Uuid& /*person*/) { return {}; }
  // Whatever happens while it is done, the person counts as erased from the first step on.
  virtual Status Destroy(const Uuid& person, int64_t now_ms) = 0;
  virtual Result<bool> IsGone(const Uuid& person) = 0;
  virtual Result<std::vector<Tombstone>> Gone() = 0;
  // The people with a key here, in order.
  virtual Result<std::vector<Uuid>> People() = 0;
  // Another key ring's key, durable on return. One that is here already stays. Errors: kConflict
  // (erased).
  virtual Status Put(const Uuid& person, const DataKey& key) = 0;
  // These people are erased here too, from now on.
  virtual Status Bury(const std::vector<Tombstone>& tombstones) = 0;
  // Since the last call that was done; ok where nothing can be away.
  virtual Status Problem() const { return Status::Ok(); }
  // As Blobs::Look and Blobs::Figures.
  virtual void Look() {}
  virtual std::optional<s3::S3Figures> Figures() const { return {}; }
};

// Takes the other's keys and erasures besides those in `keyring`. `progress` hears of so many keys
// of so many.
Status Join(Keyring& keyring, Keyring& other,
            const std::function<void(uint64_t, uint64_t)>& progress = {});

// The envelope of data under a person's key (schemas/personal_data.md, "Envelope"). The same data
// of the same attempt gives the same bytes, so that writing it again after a crash changes nothing.
Bytes SealPersonal(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data);
// The same, packed with zstd before: for text. Requires: at most 1 GiB.
Bytes SealPacked(const Uuid& person, const DataKey& key, const Uuid& attempt, ByteView data);
// None: these bytes are no envelope.
std::optional<Uuid> PersonOfSealed(ByteView bytes);
// Opens envelopes; returns all other content unchanged, because it belongs to nobody. Errors:
// kNotFound (key destroyed), kStorage (damaged), kVersion.
Result<Bytes> OpenPersonal(Keyring& keyring, Bytes bytes);
// The same for many in a row, mostly of one person; it fetches that key once. One thread.
class PersonalReader {
 public:
  explicit PersonalReader(Keyring& keyring) : keyring_(keyring) {}
  Result<Bytes> Open(Bytes bytes);

 private:
  Keyring& keyring_;
  std::optional<std::pair<Uuid, DataKey>> last_;
};
// Whether an envelope was made of something of this attempt: its nonce is derived from that and the
// content. Errors: those of OpenPersonal; kInvalidInput (these bytes are no envelope).
Result<bool> IsOfAttempt(Keyring& keyring, const Bytes& sealed, const Uuid& attempt);

}  // namespace enamel::server
