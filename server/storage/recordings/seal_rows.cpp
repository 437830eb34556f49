#include "server/storage/recordings/seal_rows.h"

#include <string>

#include "common/protocol/refusals.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/recordings/trace_rows.h"

namespace enamel::server {
namespace {

// Whether the work was late is certain when its ticks cannot have been made between ticket and due
// time; when only the upload was, it may have been made before.
uint32_t LateFlags(const Ingest& ingest) {
  if (ingest.due_ms == 0 || (ingest.flags & kLate) != 0) return 0;
  UnixMs shortest_ms = ingest.rate_hz > 0 ? static_cast<UnixMs>(ingest.ticks + ingest.gap_ticks) *
                                                1000 / ingest.rate_hz
                                          : 0;
  if (ingest.ticketed_ms + shortest_ms > ingest.due_ms) return kLate;
  if (ingest.last_chunk_ms > ingest.due_ms) return kLateUpload;
  return 0;
}

// All four: chunks and ticks say that nothing is missing, the hash that it is this chain, the
// state hash that both have the same tooth.
Status SealMatches(const Ingest& ingest, const trace::Seal& seal) {
  if (seal.chunks == ingest.chunks && seal.ticks == ingest.ticks &&
      seal.last_chunk == ingest.head && seal.state_hash == ingest.head_state_hash) {
    return Status::Ok();
  }
  return Status(Code::kConflict, "the seal names " + std::to_string(seal.chunks) + " chunks, " +
                                     std::to_string(seal.ticks) + " ticks and the last chunk " +
                                     seal.last_chunk.Hex() + "; committed are " +
                                     std::to_string(ingest.chunks) + ", " +
                                     std::to_string(ingest.ticks) + " and " + ingest.head.Hex() +
                                     "; send what is missing, then seal again");
}

Status MarkSealed(Db& db, const Uuid& attempt, const Ingest& ingest, const TraceBlobs& blobs,
                  UnixMs now_ms, bool keep_rows) {
  ENAMEL_RETURN_IF_ERROR(SetParts(db, attempt, blobs.parts));
  {
    Query q(db, std::string("UPDATE attempts SET state = ") + Sql(AttemptState::kSealed) +
                    ", sealed_ms = ?3, trace_blob = ?4, flags = flags | ?5 "
                    "WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, now_ms, blobs.last, LateFlags(ingest)).Run());
  }
  // Deleting an hour's chunks here would hold up all who record: SealedRows does it in portions.
  if (keep_rows) return Status::Ok();
  Query q(db, "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2");
  return q.Bind(attempt).Run();
}

}  // namespace

// The rows go once the blob is named. A store that says yes and keeps half would then have had the
// last copy: what was put is read back.
Result<Sha256> SealRows::PutPart(const Uuid& attempt, ByteWriter& piece) {
  const Bytes bytes = piece.Take();
  piece = {};
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 blob, stored_.PutAttemptBlob(attempt, bytes));
  const Status kept = blobs_.Get(blob).status();
  if (kept.ok()) return blob;
  if (kept.code() == Code::kUnavailable) return kept;
  return Status(Code::kUnavailable, "the store of blobs did not keep what it was given (" +
                                        kept.message() +
                                        "); the recording stays where it is, try again later");
}

// Copies the committed chunks, outside the transaction that ends the attempt: after a crash in
// between, the same blobs are written again. The chunks are cut into parts by their sizes alone, so a repetition
// makes the same parts.
Result<TraceBlobs> SealRows::MoveTraceToBlobs(const trace::Seal& seal) {
  const trace::NextChunk next = recordings_.OpenRows(seal.attempt, seal.chunks);
  ENAMEL_ASSIGN_OR_RETURN(const Bytes header, recordings_.AttemptHeader(seal.attempt));
  ByteWriter piece;
  trace::BeginTraceFile(header, piece);
  TraceBlobs out;
  for (uint32_t seq = 0; seq < seal.chunks; ++seq) {
    if (piece.size() >= part_bytes_) {
      ENAMEL_ASSIGN_OR_RETURN(const Sha256 blob, PutPart(seal.attempt, piece));
      out.parts.push_back({blob, seq});
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto chunk, next());
    trace::WriteChunk(*chunk, piece);
  }
  trace::WriteSeal(seal, piece);
  ENAMEL_ASSIGN_OR_RETURN(out.last, PutPart(seal.attempt, piece));
  return out;
}

// A sealed recording that has lost a blob, from the chunks that came again.
Status SealRows::HealIfLost(const trace::Seal& seal, const Ingest& before) {
  ENAMEL_ASSIGN_OR_RETURN(const bool whole, recordings_.IsWhole(seal.attempt));
  if (whole) return Status::Ok();
  auto end = rows_.Read([&](Db& db) { return EndOfRows(db, seal.attempt); });
  ENAMEL_RETURN_IF_ERROR(end.status());
  // Nothing came again: only the answer to the seal was lost. The station is asked when it offers.
  if (end->next == 0) return Status::Ok();
  if (end->next != before.chunks || end->last != before.head) {
    return Status(Code::kConflict,
                  "the recording was lost; expected all " + std::to_string(before.chunks) +
                      " chunks of it once more, found " + std::to_string(end->next),
                  "seq");
  }
  const Result<TraceBlobs> moved = MoveTraceToBlobs(seal);
  if (!moved.ok()) {
    // Another server has its blobs and took the rows away meanwhile: they were not lost, nor did they come again.
    ENAMEL_ASSIGN_OR_RETURN(const auto left,
                            rows_.Read([&](Db& db) { return EndOfRows(db, seal.attempt); }));
    return left.next == 0 ? Status::Ok() : moved.status();
  }
  const TraceBlobs& blobs = *moved;
  recordings_.NoteWritten(seal.attempt);
  const Status status = rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto ingest, FindIngest(db, seal.attempt, Look::kToDecide));
    if (ingest.trace_blob != before.trace_blob) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, blobs.All()));
    ENAMEL_RETURN_IF_ERROR(SetParts(db, seal.attempt, blobs.parts));
    Query q(db, "UPDATE attempts SET trace_blob = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(seal.attempt, blobs.last).Run());
    return WriteAudit(
        db, Actor{{}, "station link"}, "attempt.heal", seal.attempt.Text(),
        JsonOf({{"trace", before.trace_blob.Hex()}}),
        JsonOf({{"chunks", std::to_string(seal.chunks)}, {"trace", blobs.last.Hex()}}));
  });
  if (status.ok() && sealed_ != nullptr) sealed_->Add(seal.attempt);
  return status;
}

// A seal that names fewer chunks than are committed, or as many with another last one, or that
// comes after another was taken, is of another recording. One that names more waits for them.
Status SealRows::NoteOtherSeal(const trace::Seal& seal) {
  return rows_.WriteRow([&](Db& db) -> Status {
    auto ingest = FindIngest(db, seal.attempt, Look::kToDecide);
    if (!ingest.ok() || ingest->chunks == 0 || SealMatches(*ingest, seal).ok()) return Status::Ok();
    const bool waits = ingest->trace_blob.IsZero() && seal.chunks > ingest->chunks;
    if (waits || ingest->expired) return Status::Ok();
    return Contradicted(db, seal.attempt,
                        "a seal came that names " + std::to_string(seal.chunks) +
                            " chunks and the last chunk " + seal.last_chunk.Hex() +
                            ", beside the " + std::to_string(ingest->chunks) +
                            " committed ones that end with " + ingest->head.Hex());
  });
}

Status SealRows::SealAttempt(const trace::Seal& seal, UnixMs now_ms) {
  // Asked twice: on a reader, so that no blob is written for a seal that does not fit, and in the
  // transaction that ends the attempt, as another connection may have been faster.
  auto check = [&](Db& db, Look look) -> Result<Ingest> {
    auto ingest = FindIngest(db, seal.attempt, look);
    ENAMEL_RETURN_IF_ERROR(ingest.status());
    bool quarantined = ingest->state == AttemptState::kQuarantined && ingest->trace_blob.IsZero();
    if (ingest->state == AttemptState::kTicketed || quarantined) {
      return Status(Code::kConflict, "attempt " + seal.attempt.Text() + " is " +
                                         AttemptStateName(ingest->state) + " and cannot be sealed");
    }
    ENAMEL_RETURN_IF_ERROR(SealMatches(*ingest, seal));
    return ingest;
  };
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  auto before_or = rows_.Read([&](Db& db) { return check(db, Look::kOnly); });
  if (!before_or.ok()) {
    ENAMEL_RETURN_IF_ERROR(NoteOtherSeal(seal));
    return before_or.status();
  }
  const Ingest& before = *before_or;
  // Sealed by the same seal before: the answer got lost.
  if (before.state != AttemptState::kRecording) {
    return before.trace_blob.IsZero() ? Status::Ok() : HealIfLost(seal, before);
  }
  if (before.chunks == 0)
    return Status(Code::kConflict, "an attempt without a chunk cannot be sealed");
  ENAMEL_ASSIGN_OR_RETURN(const TraceBlobs blobs, MoveTraceToBlobs(seal));
  bool fresh = false;
  Status status = rows_.WriteRow([&](Db& db) -> Status {
    fresh = false;
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, check(db, Look::kToDecide));
    if (ingest.state != AttemptState::kRecording) return Status::Ok();
    fresh = true;
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, blobs.All()));
    ENAMEL_RETURN_IF_ERROR(MarkSealed(db, seal.attempt, ingest, blobs, now_ms, sealed_ != nullptr));
    // Of other work it is a flag that an instructor sees; of an exam nothing is scored before one
    // has looked. Nor is graded work with a hand that was not admitted, which a ticket was refused
    // for or would have been.
    if ((ingest.flags & kOtherHand) != 0) {
      ENAMEL_RETURN_IF_ERROR(Quarantine(
          db, seal.attempt,
          Status(Code::kConflict,
                 "the assignment does not allow the device that held the tool. An instructor can "
                 "have the attempt scored anyway",
                 protocol::kOtherHand)));
    } else if (ingest.exam && (ingest.flags & kFasterThanTime) != 0) {
      ENAMEL_RETURN_IF_ERROR(Quarantine(
          db, seal.attempt,
          Status(Code::kConflict,
                 "this exam has more ticks than the time between its ticket and their arrival "
                 "allows: it was not made in real time. An instructor can have it scored anyway",
                 protocol::kFasterThanTime)));
    } else {
      ENAMEL_RETURN_IF_ERROR(QueueScoreJob(db, seal.attempt, "seal"));
    }
    return WriteAudit(
        db, Actor{{}, "station link"}, "attempt.seal", seal.attempt.Text(), "{}",
        JsonOf({{"chunks", std::to_string(seal.chunks)}, {"trace", blobs.last.Hex()}}));
  });
  if (status.ok() && fresh) {
    ++counters_.sealed;
    if (sealed_ != nullptr) sealed_->Add(seal.attempt);
  }
  return status;
}

Status SealRows::AcceptCommitted(const Uuid& attempt, const Actor& by) {
  // Quarantined while it was recorded: there will be no seal from the station any more.
  auto unsealed = [](const Ingest& ingest) {
    return ingest.state == AttemptState::kQuarantined && ingest.trace_blob.IsZero() &&
           !ingest.expired && ingest.chunks > 0;
  };
  auto before = rows_.Read([&](Db& db) { return FindIngest(db, attempt, Look::kOnly); });
  ENAMEL_RETURN_IF_ERROR(before.status());
  if (!unsealed(*before)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  ENAMEL_ASSIGN_OR_RETURN(const TraceBlobs blobs,
                          MoveTraceToBlobs({attempt, before->chunks, before->ticks, before->head,
                                            before->head_state_hash}));
  bool fresh = false;
  Status status = rows_.Write([&](Db& db) -> Status {
    fresh = false;
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kToDecide));
    if (!unsealed(ingest)) return Status::Ok();
    fresh = true;
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, blobs.All()));
    ENAMEL_RETURN_IF_ERROR(MarkSealed(db, attempt, ingest, blobs, NowMs(), sealed_ != nullptr));
    return WriteAudit(
        db, by, "attempt.accept", attempt.Text(), "{}",
        JsonOf({{"chunks", std::to_string(ingest.chunks)}, {"trace", blobs.last.Hex()}}));
  });
  if (status.ok() && fresh && sealed_ != nullptr) sealed_->Add(attempt);
  return status;
}

}  // namespace enamel::server
