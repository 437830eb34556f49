#pragma once

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/trace/trace.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/recordings/ingest_counters.h"
#include "server/storage/recordings/recording_rows.h"
#include "server/storage/recordings/sealed_rows.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/recordings/trace_parts.h"
#include "server/training/types.h"

namespace enamel::server {

// Ends recordings.
class SealRows {
 public:
  // A part of a recording ends with the chunk that makes it `part_bytes` long.
  SealRows(Transactions& rows, RecordingGate& gate, Blobs& blobs, StoredBlobs& stored,
           RecordingRows& recordings, SealedRows* sealed, IngestCounters& counters,
           size_t part_bytes)
      : rows_(rows),
        gate_(gate),
        blobs_(blobs),
        stored_(stored),
        recordings_(recordings),
        sealed_(sealed),
        counters_(counters),
        part_bytes_(part_bytes) {}

  // Seals an unsealed quarantined attempt with its committed part. Any other attempt: nothing.
  Status AcceptCommitted(const Uuid& attempt, const Actor& by);
  // Refuses a seal that does not match the committed chunks (kConflict). Moves the trace from rows
  // into write-once blobs (trace_parts.h), whatever its size with the memory of a few parts, and
  // queues a "score" job; an exam made faster than time is quarantined instead, and Rescore is how an instructor accepts it.
  // Sets kLate when the ticks cannot have been made between ticket and due time, else kLateUpload
  // when the last chunk came after it. Idempotent; of a sealed recording that the store has lost
  // (RecordingRows::IsWhole) it makes new blobs of the chunks that came again, which changes
  // nothing else. Errors also: kConflict with field "seq" (of those some are missing still).
  Status SealAttempt(const trace::Seal& seal, UnixMs now_ms);

 private:
  Result<TraceBlobs> MoveTraceToBlobs(const trace::Seal& seal);
  Result<Sha256> PutPart(const Uuid& attempt, ByteWriter& piece);
  Status HealIfLost(const trace::Seal& seal, const Ingest& before);
  // Flags the attempt when the seal is of a recording other than the committed one.
  Status NoteOtherSeal(const trace::Seal& seal);

  Transactions& rows_;
  RecordingGate& gate_;
  Blobs& blobs_;
  StoredBlobs& stored_;
  RecordingRows& recordings_;
  SealedRows* sealed_;
  IngestCounters& counters_;
  const size_t part_bytes_;
};

}  // namespace enamel::server
