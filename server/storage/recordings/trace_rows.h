#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/engine/query.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/training/types.h"

// Private to server/storage/attempts: a recording inside a transaction, during and after its
// upload.
namespace enamel::server {

// The part of an attempt's row that a recording changes.
struct Ingest {
  AttemptState state = AttemptState::kTicketed;
  bool has_header = false;
  Sha256 head;
  uint64_t head_state_hash = 0;
  uint32_t chunks = 0;
  uint64_t ticks = 0;
  Sha256 trace_blob;
  bool expired = false;
  uint64_t gap_ticks = 0, trace_bytes = 0;
  UnixMs ticketed_ms = 0, due_ms = 0, last_chunk_ms = 0;
  int64_t rate_hz = 0;
  uint32_t flags = 0;
  bool exam = false;
};

// To read, or to decide: then nobody else changes it before the transaction's end.
enum class Look { kOnly, kToDecide };
// Errors: kNotFound.
Result<Ingest> FindIngest(Db& db, const Uuid& attempt, Look look);

// Errors: kNotFound (nothing was recorded).
Result<Bytes> HeaderOf(Db& db, const Uuid& attempt);
// Reads kRowsAtOnce chunks that are rows, from number `from` on, in order and still encrypted under
// the person's key. None after the seal, when they are in blobs.
Result<std::vector<Bytes>> ChunkRowsFrom(Db& db, const Uuid& attempt, uint32_t from);
// Chunks that are read into memory at once, of at most a mebibyte each.
inline constexpr int64_t kRowsAtOnce = 16;
// Where those end.
struct ChunkEnd {
  uint32_t next = 0;  // number of the chunk that follows
  Sha256 last;        // what it names as previous
};
// Errors: kNotFound (nothing was recorded).
Result<ChunkEnd> EndOfRows(Db& db, const Uuid& attempt);
Status InsertChunk(Db& db, const ChunkPut& chunk, ByteView sealed);
// kNotFound: a retention rule removed it.
Status Expired(const Uuid& attempt);

// Keeps a chunk that contradicts the committed one. `sealed`: under the person's key.
Status KeepEvidence(Db& db, const ChunkPut& chunk, ByteView sealed);
Status Quarantine(Db& db, const Uuid& attempt, const Status& problem);
// Records a second recording made with the same ticket: a copy of a station's folder can use its
// tickets once more. The order of arrival proves nothing, so neither counts as the right one: the
// attempt is flagged, the committed part stays, and the reason names the other.
Status Contradicted(Db& db, const Uuid& attempt, const std::string& problem);

}  // namespace enamel::server
