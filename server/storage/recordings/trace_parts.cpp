#include "server/storage/recordings/trace_parts.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {

std::set<Sha256> TraceBlobs::All() const {
  std::set<Sha256> out{last};
  for (const TracePart& part : parts) out.insert(part.content);
  return out;
}

Result<std::vector<TracePart>> PartsOf(sql::Db& db, const Uuid& attempt) {
  Query q(db,
          "SELECT content, next_chunk FROM trace_parts WHERE tenant = ?1 AND attempt = ?2 ORDER BY "
          "next_chunk");
  return q.Bind(attempt).All<TracePart>();
}

Status SetParts(sql::Db& db, const Uuid& attempt, const std::vector<TracePart>& parts) {
  Query gone(db, "DELETE FROM trace_parts WHERE tenant = ?1 AND attempt = ?2");
  ENAMEL_RETURN_IF_ERROR(gone.Bind(attempt).Run());
  for (const TracePart& part : parts) {
    ENAMEL_RETURN_IF_ERROR(Insert(db, "trace_parts", "attempt", attempt, "next_chunk",
                                  part.next_chunk, "content", part.content));
  }
  return Status::Ok();
}

Status DropParts(sql::Db& db, const Uuid& attempt, std::set<Sha256>& blobs) {
  ENAMEL_ASSIGN_OR_RETURN(const auto parts, PartsOf(db, attempt));
  for (const TracePart& part : parts) blobs.insert(part.content);
  return SetParts(db, attempt, {});
}

void PartsReader::SkipTo(uint32_t chunk, Bytes header) {
  from_ = chunk;
  while (next_blob_ < blobs_.parts.size() && blobs_.parts[next_blob_].next_chunk <= chunk) {
    next_chunk_ = blobs_.parts[next_blob_++].next_chunk;
  }
  if (next_blob_ > 0) reader_ = trace::PieceReader(std::move(header));
}

// At the end of a blob.
Status PartsReader::CheckEnd() const {
  const bool last = next_blob_ > blobs_.parts.size();
  if (!reader_.truncated() && reader_.seal().has_value() == last &&
      (last || blobs_.parts[next_blob_ - 1].next_chunk == next_chunk_)) {
    return Status::Ok();
  }
  return Status(Code::kStorage, "part " + std::to_string(next_blob_) + " of " +
                                    std::to_string(blobs_.parts.size() + 1) +
                                    " of the recording does not end where it should; restore it "
                                    "from a backup");
}

Result<std::optional<Bytes>> PartsReader::Next() {
  for (;;) {
    if (is_open_) {
      const auto chunk = reader_.Next();
      if (!chunk.ok()) return Status(Code::kStorage, chunk.status().message());
      if (*chunk) {
        if (next_chunk_++ < from_) continue;
        return std::optional<Bytes>(std::in_place, (*chunk)->begin(), (*chunk)->end());
      }
      ENAMEL_RETURN_IF_ERROR(CheckEnd());
      is_open_ = false;
    }
    if (next_blob_ > blobs_.parts.size()) return std::optional<Bytes>();
    piece_.clear();  // not beside the next one
    piece_.shrink_to_fit();
    ENAMEL_ASSIGN_OR_RETURN(
        piece_,
        fetch_(next_blob_ < blobs_.parts.size() ? blobs_.parts[next_blob_].content : blobs_.last));
    reader_.Begin(piece_);
    ++next_blob_;
    is_open_ = true;
  }
}

}  // namespace enamel::server
