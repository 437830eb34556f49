#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/trace/pieces.h"
#include "common/trace/trace.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/training/types.h"

namespace enamel::server {

struct Ingest;      // trace_rows.h
struct TraceBlobs;  // trace_parts.h

// A recording as it was when it was opened, read in order. Chunks that come later are not given.
struct OpenRecording {
  uint32_t chunks = 0;
  uint64_t bytes = 0;  // of header and chunks
  bool sealed = false;
  // Holds some mebibytes of it at a time, and uses the RecordingRows that gave it. Thread safety:
  // none. Errors: as AttemptHeader; kStorage (damaged).
  trace::NextChunk next;
};

// Reads the recording of an attempt. Thread safety: any thread; calls block.
class RecordingRows {
 public:
  RecordingRows(Transactions& rows, Keyring& keyring, StoredBlobs& blobs)
      : rows_(rows), keyring_(keyring), blobs_(blobs) {}

  Result<Bytes> AttemptHeader(const Uuid& attempt);
  // From chunk number `from` on. Errors: kNotFound, also of a recording that a rule removed.
  Result<OpenRecording> Open(const Uuid& attempt, uint32_t from = 0);
  // The chunks that are rows, also of a sealed attempt, up to that number. Errors of the reading:
  // kUnavailable (rows are missing, as after another connection's seal).
  trace::NextChunk OpenRows(const Uuid& attempt, uint32_t chunks);
  // Of an attempt being made: the chunks that are committed from number `from` on, in order; of
  // more than `most` the newest. None once it is sealed.
  Result<std::vector<Bytes>> NewestChunks(const Uuid& attempt, uint32_t from, uint32_t most);
  Result<trace::Seal> AttemptSeal(const Uuid& attempt);
  // Whether the store still has a sealed recording as it was sealed: all of it, of this attempt,
  // with the content that its name says. One that is not sealed, or was removed by a rule, is whole.
  // Reads it at most once in kLookAgain, and asks each time whether it is there. Errors: kUnavailable
  // (cannot be told now).
  Result<bool> IsWhole(const Uuid& attempt);
  // It was written again: what was known of it holds no more.
  void NoteWritten(const Uuid& attempt);
  // The number of the chunk that the station is to send next: what follows the committed ones, or of
  // a recording that is lost (IsWhole) those that came again.
  Result<uint32_t> NextChunk(const Uuid& attempt);
  // The chunks that contradict committed ones, as far as they were kept; by number.
  Result<std::vector<ContradictionRow>> ContradictionsOf(const Uuid& attempt);

 private:
  static constexpr std::chrono::hours kLookAgain{24};
  static constexpr std::chrono::minutes kLostAgain{1};
  static constexpr size_t kMaxSeen = 100'000;
  struct Seen {
    Sha256 blob;
    bool whole = false;
    std::chrono::steady_clock::time_point at;
  };
  Result<bool> Reads(const Uuid& attempt, const Ingest& ingest, const TraceBlobs& blobs);

  Transactions& rows_;
  Keyring& keyring_;
  StoredBlobs& blobs_;
  Mutex mutex_;
  std::map<Uuid, Seen> seen_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server
