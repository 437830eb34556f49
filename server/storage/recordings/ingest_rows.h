#pragma once

#include <cstdint>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/trace/trace.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/data_key.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/attempt_keys.h"
#include "server/storage/recordings/ingest_counters.h"
#include "server/storage/recordings/recording_rows.h"
#include "server/training/types.h"

namespace enamel::server {

struct ChunkPut {
  Uuid attempt;
  trace::ChunkHead head;
  Sha256 hash;
  Bytes bytes;
  UnixMs received_ms = 0;
};

// Takes the chunks of recordings in.
class IngestRows {
 public:
  IngestRows(Transactions& rows, RecordingGate& gate, Keyring& keyring, AttemptKeys& keys,
             RecordingRows& recordings, IngestCounters& counters)
      : rows_(rows),
        gate_(gate),
        keyring_(keyring),
        keys_(keys),
        recordings_(recordings),
        counters_(counters) {}

  // Durable on return, encrypted under the person's key. Idempotent by (attempt, seq, hash). Same
  // seq with another hash: kConflict, the attempt is quarantined and both are kept. Out of order,
  // or not continuing the stored chain (first tick, previous hash): kInvalidInput naming the
  // expected value. Concurrent callers share one fsync. Sets kFasterThanTime when the attempt then
  // has more ticks and gaps than fit between its ticket and received_ms (2 s and 1 % more are
  // granted, for clocks), kOverTime beyond its limit. Errors also: kTooLarge (recording_bounds.h).
  Status AppendChunk(const ChunkPut& chunk);

 private:
  // A key that counts while the person's key is of this generation; 0: whatever that is.
  struct KeyForChunk {
    Uuid person;
    DataKey key;
    int64_t generation = 0;
  };
  enum class Appended {
    kNow,
    kBefore,   // the same chunk is committed: the station did not get the answer
    kSealed,   // the attempt is sealed, and its blob says whether it has the chunk
    kNotDone,  // the key may count no more, or the chunk is not the next one: ask for the key
  };
  // kNotDone for a key with a generation only.
  Result<Appended> AppendWith(const KeyForChunk& key, const ChunkPut& chunk);
  static Result<Appended> LookAndAppend(sql::Db& db, const ChunkPut& chunk, ByteView sealed,
                                        bool& keep_anyway);
  Status RepeatedAfterSeal(const ChunkPut& chunk);
  Status TakeAgain(const ChunkPut& chunk);
  void Count(const ChunkPut& chunk);

  Transactions& rows_;
  RecordingGate& gate_;
  Keyring& keyring_;
  AttemptKeys& keys_;
  RecordingRows& recordings_;
  IngestCounters& counters_;
};

}  // namespace enamel::server
