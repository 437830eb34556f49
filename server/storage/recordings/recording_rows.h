#pragma once

#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/trace/trace.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/training/types.h"

namespace enamel::server {

// Reads the recording of an attempt.
class RecordingRows {
 public:
  RecordingRows(Transactions& rows, Keyring& keyring, StoredBlobs& blobs)
      : rows_(rows), keyring_(keyring), blobs_(blobs) {}

  Result<Bytes> AttemptHeader(const Uuid& attempt);
  Result<std::vector<Bytes>> AttemptChunks(const Uuid& attempt);
  // Of an attempt being made: the chunks that are committed from number `from` on, in order; of
  // more than `most` the newest. None once it is sealed.
  Result<std::vector<Bytes>> NewestChunks(const Uuid& attempt, uint32_t from, uint32_t most);
  Result<trace::Seal> AttemptSeal(const Uuid& attempt);
  // The chunks that contradict committed ones, as far as they were kept; by number.
  Result<std::vector<ContradictionRow>> ContradictionsOf(const Uuid& attempt);

 private:
  Transactions& rows_;
  Keyring& keyring_;
  StoredBlobs& blobs_;
};

}  // namespace enamel::server
