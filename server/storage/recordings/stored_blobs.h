#pragma once

#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/attempt_keys.h"

namespace enamel::server {

// Content-addressed blobs as everybody outside the store sees them: documents, volumes, sealed
// results. Write-once, durable on return.
class StoredBlobs {
 public:
  StoredBlobs(RecordingGate& gate, Blobs& blobs, Keyring& keyring, AttemptKeys& keys)
      : gate_(gate), blobs_(blobs), keyring_(keyring), keys_(keys) {}

  Result<Sha256> PutBlob(ByteView data);
  Result<Bytes> GetBlob(const Sha256& hash);
  bool HasBlob(const Sha256& hash);
  // A blob that shows what the attempt's person did: kept under that person's key, readable through
  // GetBlob as long as the key exists. Errors also: kNotFound (attempt), kConflict (person erased).
  Result<Sha256> PutAttemptBlob(const Uuid& attempt, ByteView data);
  // The same of text, which is packed.
  Result<Sha256> PutAttemptText(const Uuid& attempt, std::string_view text);

 private:
  RecordingGate& gate_;
  Blobs& blobs_;
  Keyring& keyring_;
  AttemptKeys& keys_;
};

}  // namespace enamel::server
