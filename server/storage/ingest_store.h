#pragma once

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// How an attempt comes in: ticket, header, chunks, seal.
// A part of Store (store.h), which says what holds for all parts.
class IngestStore {
 public:
  virtual ~IngestStore() = default;

  // Attempts and their traces. `ticket` is what OpenAttempt's header must contain: one ticket, one
  // attempt, one header. With an assignment: kForbidden when its attempt limit is used up (field
  // "attempt_limit"), or, as an exam, when the person has another exam attempt that is not sealed
  // (field "exam"), unless kReadmitted is set; decided in the transaction, so that two stations
  // cannot both have the last one. Errors also: kNotFound with field "person", "station" or
  // "exercise" (which is not here), kConflict with field "person" (erased).
  virtual Status CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by) = 0;
  // The attempt's ticket was handed back unused: sets kReturned, and the attempt can no longer be
  // opened. Again: nothing changes. Errors: kNotFound, kConflict (it was opened).
  virtual Status ReturnTicket(const Uuid& attempt, const Actor& by) = 0;
  // First or repeated; kConflict when another header is stored, or the ticket was returned. Whether
  // the ticket inside the header is genuine and in time is for the caller to have checked.
  virtual Status OpenAttempt(const Uuid& attempt, ByteView header) = 0;
  // AttemptRow::facts from now on. Errors: kNotFound.
  virtual Status KeepFacts(const Uuid& attempt, const std::string& facts) = 0;
  struct ChunkPut {
    Uuid attempt;
    trace::ChunkHead head;
    Sha256 hash;
    Bytes bytes;
    UnixMs received_ms = 0;
  };
  // Durable on return, kept under the person's key. Idempotent by (attempt, seq, hash). Same seq
  // with another hash: kConflict, the attempt is quarantined and both are kept. Out of order, or
  // not continuing the stored chain (first tick, previous hash): kInvalidInput naming what was
  // expected. Concurrent callers share one fsync. Sets kFasterThanTime when the attempt then has
  // more ticks and gaps than fit between its ticket and received_ms (2 s and 1 % more are granted,
  // for clocks), kOverTime beyond its limit.
  virtual Status AppendChunk(const ChunkPut& chunk) = 0;
  // Refuses a seal that does not match the committed chunks (kConflict). Moves the trace from rows
  // into one write-once blob (a trace file, schemas/trace_format.md) and queues a "score" job; an
  // exam made faster than time is quarantined instead, and Rescore is how an instructor accepts it.
  // Sets kLate when the ticks cannot have been made between ticket and due time, else kLateUpload
  // when the last chunk came after it. Idempotent.
  virtual Status SealAttempt(const trace::Seal& seal, UnixMs now_ms) = 0;
};

}  // namespace enamel::server
