#include "server/storage/blobs/blob_rows.h"

#include <algorithm>
#include <string>

#include "server/storage/blobs/named_blobs.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr char kFind[] = "SELECT hash, bytes, generation, put_ms FROM blobs WHERE tenant = ?1";

Status Set(sql::Db& db, const BlobRow& row) {
  Query q(db, "UPDATE blobs SET generation = ?3, put_ms = ?4 WHERE tenant = ?1 AND hash = ?2");
  return q.Bind(row.hash, row.generation, row.put_ms).Run();
}

// Locked: in a transaction of Isolation::kRowLocks it could change between this and Set.
Result<std::optional<BlobRow>> FindToChange(sql::Db& db, const Sha256& hash) {
  Query q(db, std::string(kFind) + " AND hash = ?2" + db.RowLock());
  return q.Bind(hash).Maybe<BlobRow>();
}

}  // namespace

Result<std::optional<BlobRow>> FindBlobRow(sql::Db& db, const Sha256& hash) {
  Query q(db, std::string(kFind) + " AND hash = ?2");
  return q.Bind(hash).Maybe<BlobRow>();
}

Result<std::vector<BlobRow>> AllBlobRows(sql::Db& db) {
  Query q(db, kFind);
  return q.All<BlobRow>();
}

Result<std::optional<BlobRow>> TouchBlobRow(sql::Db& db, const Sha256& hash, int64_t now_ms) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, FindToChange(db, hash));
  if (!row) return row;
  // A clock that is behind another server's takes nothing back.
  row->put_ms = std::max(row->put_ms, now_ms);
  ENAMEL_RETURN_IF_ERROR(Set(db, *row));
  return row;
}

Result<BlobRow> ClaimBlobRow(sql::Db& db, const BlobRow& put, int64_t lost) {
  ENAMEL_ASSIGN_OR_RETURN(const auto there, FindToChange(db, put.hash));
  if (there) {
    BlobRow row = *there;
    row.put_ms = std::max(row.put_ms, put.put_ms);
    if (row.generation == lost) row.generation = put.generation;
    ENAMEL_RETURN_IF_ERROR(Set(db, row));
    return row;
  }
  ENAMEL_RETURN_IF_ERROR(Insert(db, "blobs", "hash", put.hash, "bytes", put.bytes, "generation",
                                put.generation, "put_ms", put.put_ms));
  return put;
}

Result<std::vector<BlobRow>> DeleteUnnamedBlobRows(sql::Db& db, const std::set<Sha256>& hashes,
                                                   int64_t before_ms) {
  std::vector<BlobRow> out;
  if (hashes.empty()) return out;
  ENAMEL_ASSIGN_OR_RETURN(const auto named, NamedBlobs(db));
  for (const Sha256& hash : hashes) {
    if (named.contains(hash)) continue;
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindBlobRow(db, hash));
    if (!row || row->put_ms >= before_ms) continue;
    Query q(db, "DELETE FROM blobs WHERE tenant = ?1 AND hash = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(hash).Run());
    out.push_back(*row);
  }
  return out;
}

}  // namespace enamel::server
