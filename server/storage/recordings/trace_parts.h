#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "common/trace/pieces.h"

// A sealed recording as blobs: pieces of its trace file that end where records do, together the
// whole file. Most recordings are one blob. A longer one is several, so that nobody needs all of it in memory,
// and no store needs minutes for one object.
namespace enamel::server {

struct TracePart {
  Sha256 content;
  uint32_t next_chunk = 0;  // number of the chunk that follows
};
// `parts` in order, then `last`, which has the seal.
struct TraceBlobs {
  std::vector<TracePart> parts;
  Sha256 last;

  std::set<Sha256> All() const;
};

// Rows of the table `trace_parts`; the last blob is the attempt's `trace_blob`. Inside a transaction.
Result<std::vector<TracePart>> PartsOf(sql::Db& db, const Uuid& attempt);
// Replaces the attempt's rows.
Status SetParts(sql::Db& db, const Uuid& attempt, const std::vector<TracePart>& parts);
// Deletes them, and adds the blobs that they named.
Status DropParts(sql::Db& db, const Uuid& attempt, std::set<Sha256>& blobs);

// Reads a sealed recording, one blob of it in memory at a time. Thread safety: none.
class PartsReader {
 public:
  // The content of a blob, outside its envelope.
  using Fetch = std::function<Result<Bytes>(const Sha256&)>;

  PartsReader(TraceBlobs blobs, Fetch fetch) : blobs_(std::move(blobs)), fetch_(std::move(fetch)) {}
  // From a later chunk on. `header`: the recording's. Requires: nothing was read yet.
  void SkipTo(uint32_t chunk, Bytes header);

  // The next chunk; none after the last. Errors: Fetch's; kStorage (a blob is not what it should be).
  Result<std::optional<Bytes>> Next();

  // After the last chunk.
  const Bytes& header() const { return reader_.header(); }
  const std::optional<trace::Seal>& seal() const { return reader_.seal(); }

 private:
  Status CheckEnd() const;

  const TraceBlobs blobs_;
  const Fetch fetch_;
  size_t next_blob_ = 0;
  uint32_t next_chunk_ = 0, from_ = 0;
  bool is_open_ = false;
  Bytes piece_;
  trace::PieceReader reader_;
};

}  // namespace enamel::server
