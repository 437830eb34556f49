#include "server/storage/recordings/trace_rows.h"

#include <string>
#include <vector>

#include "server/storage/attempts/attempt_flags.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/recordings/ingest_rows.h"

namespace enamel::server {
Result<Ingest> FindIngest(Db& db, const Uuid& attempt, Look look) {
  Query q(db, std::string(
                  "SELECT state, header IS NOT NULL, head_hash, head_state_hash, chunks, ticks, "
                  "trace_blob, expired_ms, gap_ticks, ticketed_ms, due_ms, last_chunk_ms, rate_hz, "
                  "flags, exam, trace_bytes FROM attempts WHERE tenant = ?1 AND id = ?2") +
                  (look == Look::kToDecide ? db.RowLock() : ""));
  if (!q.Bind(attempt).Next()) {
    ENAMEL_RETURN_IF_ERROR(q.status());
    return Status(Code::kNotFound,
                  "no attempt " + attempt.Text() + "; its ticket was not issued here");
  }
  Ingest out;
  q.Read(0, out.state, out.has_header, out.head, out.head_state_hash, out.chunks, out.ticks,
         out.trace_blob, out.expired, out.gap_ticks, out.ticketed_ms, out.due_ms, out.last_chunk_ms,
         out.rate_hz, out.flags, out.exam, out.trace_bytes);
  return out;
}

Result<Bytes> HeaderOf(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT header FROM attempts WHERE tenant = ?1 AND id = ?2");
  bool found = q.Bind(attempt).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (!found || q.IsNull(0)) {
    return Status(Code::kNotFound, "attempt " + attempt.Text() + " has no recording");
  }
  return q.Blob(0);
}

Result<std::vector<Bytes>> ChunkRowsFrom(Db& db, const Uuid& attempt, uint32_t from) {
  Query q(db,
          "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq >= ?3 ORDER "
          "BY seq LIMIT ?4");
  return q.Bind(attempt, from, kRowsAtOnce).All<Bytes>();
}

Result<ChunkEnd> EndOfRows(Db& db, const Uuid& attempt) {
  Query q(db,
          "SELECT seq, hash FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 ORDER BY seq DESC "
          "LIMIT 1");
  if (q.Bind(attempt).Next()) return ChunkEnd{static_cast<uint32_t>(q.Int(0)) + 1, q.Hash(1)};
  ENAMEL_RETURN_IF_ERROR(q.status());
  ENAMEL_ASSIGN_OR_RETURN(const Bytes header, HeaderOf(db, attempt));
  return ChunkEnd{0, HashSha256(header)};
}

Status InsertChunk(Db& db, const ChunkPut& chunk, ByteView sealed) {
  Query row(db,
            "INSERT INTO trace_chunks (tenant, attempt, seq, hash, bytes, received_ms) VALUES (?1, "
            "?2, ?3, ?4, ?5, ?6)");
  row.Bind(chunk.attempt, chunk.head.seq, chunk.hash, sealed);
  return row.Bind(chunk.received_ms).Run();
}

Status Expired(const Uuid& attempt) {
  return Status(Code::kNotFound, "the recording of attempt " + attempt.Text() +
                                     " was removed by a retention rule; its score stays");
}

namespace {

// Enough to show what happened; a station that is broken or hostile cannot fill the disk with it.
constexpr int kMaxEvidence = 16;

}  // namespace

// Counted in the statement that inserts: many connections at once cannot pass the bound.
Status KeepEvidence(Db& db, const ChunkPut& chunk, ByteView sealed) {
  Query q(db,
          "INSERT INTO contradicting_chunks (tenant, attempt, seq, hash, bytes, received_ms) "
          "SELECT ?1, ?2, ?3, ?4, ?5, ?6 WHERE (SELECT count(*) FROM contradicting_chunks "
          "WHERE tenant = ?1 AND attempt = ?2) < ?7 ON CONFLICT DO NOTHING");
  ENAMEL_RETURN_IF_ERROR(
      q.Bind(chunk.attempt, chunk.head.seq, chunk.hash, sealed, chunk.received_ms, kMaxEvidence)
          .Run());
  if (db.Changes() == 0) return Status::Ok();
  return WriteAudit(db, Actor{{}, "station link"}, "attempt.evidence", chunk.attempt.Text(), "{}",
                    JsonOf({{"content", chunk.hash.Hex()}}));
}

Status Quarantine(Db& db, const Uuid& attempt, const Status& problem) {
  Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kQuarantined) +
                  ", problem = ?3, problem_field = ?4 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, problem.message(), problem.field()).Run());
  return WriteAudit(db, Actor{{}, "station link"}, "attempt.quarantine", attempt.Text(), "{}",
                    JsonOf({{"problem", problem.message()}, {"problem_field", problem.field()}}));
}

Status Contradicted(Db& db, const Uuid& attempt, const std::string& problem) {
  return SetFlags(db, attempt, kContradicted,
                  problem +
                      "; one ticket was used for two recordings. The other one is still in "
                      "its station's spool",
                  Actor{{}, "station link"});
}

}  // namespace enamel::server
