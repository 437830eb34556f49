#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"

// Rows of the table `blobs` (schemas/sql/0001_initial.sql), for S3Blobs. Each function is part of a
// transaction of the caller's. Private to server/storage.
namespace enamel::server {

struct BlobRow {
  Sha256 hash;
  int64_t bytes = 0;
  int64_t generation = 0;
  int64_t put_ms = 0;
};

Result<std::optional<BlobRow>> FindBlobRow(sql::Db& db, const Sha256& hash);
Result<std::vector<BlobRow>> AllBlobRows(sql::Db& db);
// For a blob that is already stored, when somebody puts or names it again: `put_ms` is now. Writes
// the row in any case, so that a transaction that deletes it conflicts with this one. Returns the
// row afterwards; none: there is none.
Result<std::optional<BlobRow>> TouchBlobRow(sql::Db& db, const Sha256& hash, int64_t now_ms);
// Records that the object of `put`'s generation exists. Returns the row afterwards: of another
// generation if another server was faster. Replaces a row of the generation `lost`, whose object is
// missing.
Result<BlobRow> ClaimBlobRow(sql::Db& db, const BlobRow& put, int64_t lost);
// Deletes the rows of those of `hashes` that no row names and that were put before `before_ms`.
// Those that are deleted. Of a transaction of Isolation::kSerial.
Result<std::vector<BlobRow>> DeleteUnnamedBlobRows(sql::Db& db, const std::set<Sha256>& hashes,
                                                   int64_t before_ms);

}  // namespace enamel::server
