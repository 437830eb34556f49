#include "server/storage/recordings/ingest_rows.h"

#include <bit>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/protocol/refusals.h"
#include "server/storage/attempts/attempt_flags.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/recording_bounds.h"
#include "server/storage/recordings/trace_rows.h"

namespace enamel::server {
namespace {

// Tolerance for an inaccurate station clock and a changed server clock before ticks count as more
// than time: 2 s and 1 %.
constexpr int64_t kClockSlackMs = 2000, kClockPercent = 101;

constexpr char kInsertChunk[] =
    "INSERT INTO trace_chunks (tenant, attempt, seq, hash, bytes, received_ms) ";

Result<std::optional<Sha256>> StoredHash(Db& db, const Uuid& attempt, uint32_t seq) {
  Query q(db, "SELECT hash FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq = ?3");
  return q.Bind(attempt, seq).Maybe<Sha256>();
}

// A chunk of a number that is committed already, before the seal. After it: RepeatedAfterSeal.
Status Repeated(Db& db, const Ingest& ingest, const ChunkPut& chunk, ByteView sealed,
                bool& keep_anyway) {
  ENAMEL_ASSIGN_OR_RETURN(auto stored, StoredHash(db, chunk.attempt, chunk.head.seq));
  if (!stored || *stored == chunk.hash) return Status::Ok();
  std::string problem = "chunk " + std::to_string(chunk.head.seq) +
                        " came twice with different content: " + stored->Hex() + " is committed, " +
                        chunk.hash.Hex() + " was refused";
  ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
  // Reported once, however often it comes. The flag first: the row that is written last states it.
  if (ingest.state != AttemptState::kQuarantined) {
    Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(chunk.attempt, kContradicted).Run());
    ENAMEL_RETURN_IF_ERROR(
        Quarantine(db, chunk.attempt, Status(Code::kConflict, problem, protocol::kContradicted)));
  } else {
    ENAMEL_RETURN_IF_ERROR(
        SetFlags(db, chunk.attempt, kContradicted, problem, Actor{{}, "station link"}));
  }
  keep_anyway = true;
  return Status(Code::kConflict, problem + "; the attempt is quarantined, ask the instructor",
                "seq");
}

// Checked in the writing transaction, which orders the chunks of two connections of one station.
// After a refusal the station asks for the server's position.
Status MustContinue(const Ingest& ingest, const trace::ChunkHead& head) {
  if (head.seq != ingest.chunks) {
    return Status(Code::kConflict,
                  "expected chunk " + std::to_string(ingest.chunks) + ", found " +
                      std::to_string(head.seq) + "; send the missing ones first",
                  "seq");
  }
  if (head.first_tick != ingest.ticks) {
    return Status(Code::kConflict,
                  "chunk " + std::to_string(head.seq) + " must begin at tick " +
                      std::to_string(ingest.ticks) + ", it begins at " +
                      std::to_string(head.first_tick),
                  "first_tick");
  }
  if (head.previous != ingest.head) {
    return Status(Code::kConflict,
                  "chunk " + std::to_string(head.seq) + " must follow " + ingest.head.Hex() +
                      ", it names " + head.previous.Hex(),
                  "previous");
  }
  return Status::Ok();
}

// Counts the next chunk of an attempt; changes nothing if it does not fit. The statement itself
// checks that it fits (MustContinue puts it in words). `in_one`: it also inserts the chunk, because
// with a server every statement is a message, which costs more than the rows. The counts go with
// the chunk, so that reading an attempt never reads its chunks. `generation`: of the person's key,
// 0: any (Keyring::Remember). `chunk` and `sealed` must outlive the statement.
sql::Change NextChunk(const ChunkPut& chunk, ByteView sealed, int64_t generation, bool in_one) {
  sql::Change next;
  next.sql =
      "UPDATE attempts SET head_hash = ?3, head_state_hash = ?4, chunks = chunks + 1, "
      "ticks = ticks + ?5, gap_ticks = gap_ticks + ?6, trace_bytes = trace_bytes + ?7, "
      "last_chunk_ms = ?8, flags = flags | "
      "CASE WHEN rate_hz > 0 AND (ticks + gap_ticks + ?5 + ?6) * 100000 > rate_hz * ?9 * (?8 - "
      "ticketed_ms + ?10) THEN " +
      Sql(kFasterThanTime) +
      " ELSE 0 END | "
      "CASE WHEN limit_ticks > 0 AND ticks + gap_ticks + ?5 + ?6 > limit_ticks THEN " +
      Sql(kOverTime) +
      " ELSE 0 END WHERE tenant = ?1 AND id = ?2 AND state = " + Sql(AttemptState::kRecording) +
      " AND header IS NOT NULL AND chunks = ?11 AND ticks = ?12 AND head_hash = ?13 AND " +
      FitsSql("?5", "?6", "?7", "?8");
  if (generation != 0) {
    next.sql +=
        " AND EXISTS (SELECT 1 FROM person_keys k WHERE k.tenant = ?1 AND k.person = "
        "attempts.person AND k.generation = ?14)";
  }
  if (in_one) {
    next.sql = "WITH counted AS (" + next.sql + " RETURNING tenant, id) " + kInsertChunk +
               "SELECT tenant, id, ?11, ?3, " + (generation != 0 ? "?15" : "?14") +
               ", ?8 FROM counted";
  }
  next.bind = [&chunk, sealed, generation, in_one](sql::Query& q) {
    q.BindInt(Query::kTenant).BindBlob(chunk.attempt.view()).BindBlob(chunk.hash.view());
    q.BindInt(std::bit_cast<int64_t>(chunk.head.state_hash)).BindInt(chunk.head.count);
    q.BindInt(chunk.head.gap_ticks).BindInt(static_cast<int64_t>(chunk.bytes.size()));
    q.BindInt(chunk.received_ms).BindInt(kClockPercent).BindInt(kClockSlackMs);
    q.BindInt(chunk.head.seq).BindInt(static_cast<int64_t>(chunk.head.first_tick));
    q.BindBlob(chunk.head.previous.view());
    if (generation != 0) q.BindInt(generation);
    if (in_one) q.BindBlob(sealed);
  };
  return next;
}

// False: the chunk does not fit. Encrypted before queuing (AppendWith): the writer thread is
// shared.
Result<bool> TryAppend(Db& db, const ChunkPut& chunk, ByteView sealed, int64_t generation) {
  const bool in_one = db.GoesOnWithChanges();
  sql::Change next = NextChunk(chunk, sealed, generation, in_one);
  ENAMEL_RETURN_IF_ERROR(next.Run(db));
  if (next.rows == 0 || in_one) return next.rows > 0;
  ENAMEL_RETURN_IF_ERROR(InsertChunk(db, chunk, sealed));
  return true;
}

}  // namespace

// For a chunk that is not simply the next one.
Result<IngestRows::Appended> IngestRows::LookAndAppend(sql::Db& db, const ChunkPut& chunk,
                                                       ByteView sealed, bool& keep_anyway) {
  ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, chunk.attempt, Look::kToDecide));
  if (!ingest.has_header) {
    return Status(Code::kNotFound,
                  "attempt " + chunk.attempt.Text() + " is not open; send OpenAttempt");
  }
  // Not an error by itself: the station did not get the acknowledgement and sends again.
  if (chunk.head.seq < ingest.chunks) {
    if (!ingest.trace_blob.IsZero()) return Appended::kSealed;
    ENAMEL_RETURN_IF_ERROR(Repeated(db, ingest, chunk, sealed, keep_anyway));
    return Appended::kBefore;
  }
  Status fits = ingest.state == AttemptState::kRecording
                    ? MustContinue(ingest, chunk.head)
                    : Status(Code::kConflict, "attempt " + chunk.attempt.Text() + " is " +
                                                  AttemptStateName(ingest.state) +
                                                  " and takes no more chunks");
  // Signed by the station, and of another chain, or beyond the end of the one that was sealed.
  if (fits.field() == "previous" || (!fits.ok() && !ingest.trace_blob.IsZero())) {
    keep_anyway = true;
    ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
    ENAMEL_RETURN_IF_ERROR(Contradicted(db, chunk.attempt,
                                        "chunk " + std::to_string(chunk.head.seq) +
                                            " is of another recording than what is committed"));
  }
  ENAMEL_RETURN_IF_ERROR(fits);
  ENAMEL_RETURN_IF_ERROR(MustFit(ingest, chunk));
  // Another server has committed the chunk before it in this moment.
  ENAMEL_ASSIGN_OR_RETURN(const bool fresh, TryAppend(db, chunk, sealed, /*generation=*/0));
  ENAMEL_CHECK(fresh);
  return Appended::kNow;
}

Status IngestRows::AppendChunk(const ChunkPut& chunk) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  ENAMEL_ASSIGN_OR_RETURN(const Uuid person, keys_.PersonOf(chunk.attempt));
  if (const auto remembered = keyring_.Remember(person)) {
    const KeyForChunk key{person, remembered->key, remembered->generation};
    ENAMEL_ASSIGN_OR_RETURN(const Appended done, AppendWith(key, chunk));
    if (done != Appended::kNotDone) return Status::Ok();
  }
  ENAMEL_ASSIGN_OR_RETURN(const DataKey asked, keyring_.FindOrMake(person));
  return AppendWith({person, asked}, chunk).status();
}

Result<IngestRows::Appended> IngestRows::AppendWith(const KeyForChunk& key, const ChunkPut& chunk) {
  const Bytes sealed = SealPersonal(key.person, key.key, chunk.attempt, chunk.bytes);
  if (rows_.writer().GoesOnWithChanges()) {
    // It is sent together with others' where it needs no answer before the commit: almost always.
    sql::Change next = NextChunk(chunk, sealed, key.generation, /*in_one*/ true);
    ENAMEL_RETURN_IF_ERROR(rows_.WriteRow(next));
    if (next.rows > 0) Count(chunk);
    if (next.rows > 0) return Appended::kNow;
    if (key.generation != 0) return Appended::kNotDone;
  }
  Appended done = Appended::kNotDone;
  Status status = rows_.WriteRow(Writer::Work([&](Db& db, bool& keep_anyway) -> Status {
    done = Appended::kNotDone;
    ENAMEL_ASSIGN_OR_RETURN(const bool fresh, TryAppend(db, chunk, sealed, key.generation));
    if (fresh) done = Appended::kNow;
    if (fresh || key.generation != 0) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(done, LookAndAppend(db, chunk, sealed, keep_anyway));
    return Status::Ok();
  }));
  ENAMEL_RETURN_IF_ERROR(status);
  if (done == Appended::kNow) Count(chunk);
  if (done == Appended::kSealed) ENAMEL_RETURN_IF_ERROR(RepeatedAfterSeal(chunk));
  return done;
}

void IngestRows::Count(const ChunkPut& chunk) {
  ++counters_.chunks;
  counters_.chunk_bytes += chunk.bytes.size();
}

// The chunks are in the blob then, which is read outside the writer.
Status IngestRows::RepeatedAfterSeal(const ChunkPut& chunk) {
  ENAMEL_ASSIGN_OR_RETURN(const bool whole, recordings_.IsWhole(chunk.attempt));
  if (!whole) return TakeAgain(chunk);
  ENAMEL_ASSIGN_OR_RETURN(auto recording, recordings_.Open(chunk.attempt, chunk.head.seq));
  ENAMEL_ASSIGN_OR_RETURN(const auto there, recording.next());
  if (!there) return Status(Code::kStorage, "the sealed recording ends before this chunk");
  ENAMEL_ASSIGN_OR_RETURN(auto stored, trace::DecodeChunkHead(*there));
  if (stored.hash == chunk.hash) return Status::Ok();
  std::string problem = "chunk " + std::to_string(chunk.head.seq) + " of the sealed attempt " +
                        chunk.attempt.Text() + " is committed with other content";
  ENAMEL_ASSIGN_OR_RETURN(auto key, keys_.KeyOf(chunk.attempt));
  Bytes sealed = SealPersonal(key.person, key.key, chunk.attempt, chunk.bytes);
  const Status flagged = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
    return SetFlags(db, chunk.attempt, kContradicted, problem, Actor{{}, "station link"});
  });
  ENAMEL_RETURN_IF_ERROR(flagged);
  return Status(Code::kConflict, problem, "hash");
}

// The store has lost the sealed recording: its station sends it once more, in order. The rows are
// read by the seal that follows (SealRows); neither state nor flags nor score change.
Status IngestRows::TakeAgain(const ChunkPut& chunk) {
  ENAMEL_ASSIGN_OR_RETURN(auto key, keys_.KeyOf(chunk.attempt));
  const Bytes sealed = SealPersonal(key.person, key.key, chunk.attempt, chunk.bytes);
  return rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(FindIngest(db, chunk.attempt, Look::kToDecide).status());
    ENAMEL_ASSIGN_OR_RETURN(const ChunkEnd end, EndOfRows(db, chunk.attempt));
    if (chunk.head.seq < end.next) return Status::Ok();
    if (chunk.head.seq > end.next || chunk.head.previous != end.last) {
      return Status(Code::kConflict,
                    "expected chunk " + std::to_string(end.next) + " of the recording once more, " +
                        "found " + std::to_string(chunk.head.seq),
                    "seq");
    }
    return InsertChunk(db, chunk, sealed);
  });
}

}  // namespace enamel::server
