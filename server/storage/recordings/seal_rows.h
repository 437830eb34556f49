#pragma once

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/trace/trace.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/ingest_counters.h"
#include "server/storage/recordings/recording_rows.h"
#include "server/storage/recordings/sealed_rows.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/training/types.h"

namespace enamel::server {

// Ends recordings.
class SealRows {
 public:
  SealRows(Transactions& rows, RecordingGate& gate, Blobs& blobs, StoredBlobs& stored,
           RecordingRows& recordings, Keyring& keyring, SealedRows* sealed,
           IngestCounters& counters)
      : rows_(rows),
        gate_(gate),
        blobs_(blobs),
        stored_(stored),
        recordings_(recordings),
        keyring_(keyring),
        sealed_(sealed),
        counters_(counters) {}

  // Seals an unsealed quarantined attempt with its committed part. Any other attempt: nothing.
  Status AcceptCommitted(const Uuid& attempt, const Actor& by);
  // Refuses a seal that does not match the committed chunks (kConflict). Moves the trace from rows
  // into one write-once blob (a trace file, schemas/trace_format.md) and queues a "score" job; an
  // exam made faster than time is quarantined instead, and Rescore is how an instructor accepts it.
  // Sets kLate when the ticks cannot have been made between ticket and due time, else kLateUpload
  // when the last chunk came after it. Idempotent; of a sealed recording that the store has lost
  // (RecordingRows::IsWhole) it makes a new blob of the chunks that came again, which changes
  // nothing else. Errors also: kConflict with field "seq" (of those some are missing still).
  Status SealAttempt(const trace::Seal& seal, UnixMs now_ms);

 private:
  Result<Bytes> TraceFileOf(const trace::Seal& seal);
  Status MoveTraceToBlob(const trace::Seal& seal, Sha256& blob);
  Status HealIfLost(const trace::Seal& seal, const Ingest& before);
  // Flags the attempt when the seal is of a recording other than the committed one.
  Status NoteOtherSeal(const trace::Seal& seal);

  Transactions& rows_;
  RecordingGate& gate_;
  Blobs& blobs_;
  StoredBlobs& stored_;
  RecordingRows& recordings_;
  Keyring& keyring_;
  SealedRows* sealed_;
  IngestCounters& counters_;
};

}  // namespace enamel::server
