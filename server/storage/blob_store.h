#pragma once

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"

namespace enamel::server {

// Content-addressed blobs: documents, volumes, sealed results. Write-once, durable on return.
// A part of Store (store.h), which says what holds for all parts.
class BlobStore {
 public:
  virtual ~BlobStore() = default;

  virtual Result<Sha256> PutBlob(ByteView data) = 0;
  virtual Result<Bytes> GetBlob(const Sha256& hash) = 0;
  virtual bool HasBlob(const Sha256& hash) = 0;
  // A blob that shows what the attempt's person did: kept under that person's key, readable through
  // GetBlob as long as the key exists. Errors also: kNotFound (attempt), kConflict (person erased).
  virtual Result<Sha256> PutAttemptBlob(const Uuid& attempt, ByteView data) = 0;
};

}  // namespace enamel::server
