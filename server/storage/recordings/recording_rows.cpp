#include "server/storage/recordings/recording_rows.h"

#include <algorithm>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/trace_rows.h"

namespace enamel::server {
Result<Bytes> RecordingRows::AttemptHeader(const Uuid& attempt) {
  return rows_.Read([&](Db& db) { return HeaderOf(db, attempt); });
}

Result<std::vector<Bytes>> RecordingRows::AttemptChunks(const Uuid& attempt) {
  Sha256 blob;
  auto rows = rows_.Read([&](Db& db) -> Result<std::vector<Bytes>> {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kOnly));
    blob = ingest.trace_blob;
    if (ingest.expired) return Expired(attempt);
    if (!blob.IsZero()) return std::vector<Bytes>();
    return ChunksOf(db, attempt);
  });
  if (!rows.ok()) return rows;
  PersonalReader personal(keyring_);
  for (Bytes& row : *rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto opened, personal.Open(std::move(row)));
    row = std::move(opened);
  }
  if (blob.IsZero()) return rows;
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, blobs_.GetBlob(blob));
  ENAMEL_ASSIGN_OR_RETURN(auto file, trace::DecodeTraceFile(bytes));
  return std::move(file.chunks);
}

Result<std::vector<Bytes>> RecordingRows::NewestChunks(const Uuid& attempt, uint32_t from,
                                                       uint32_t most) {
  auto rows = rows_.Read([&](Db& db) -> Result<std::vector<Bytes>> {
    Query q(
        db,
        "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq >= ?3 ORDER BY "
        "seq DESC LIMIT ?4");
    q.Bind(attempt).Bind(int64_t{from}).Bind(int64_t{most});
    std::vector<Bytes> out;
    while (q.Next()) out.push_back(q.Blob(0));
    if (!q.status().ok()) return q.status();
    return out;
  });
  if (!rows.ok()) return rows;
  std::ranges::reverse(*rows);
  PersonalReader personal(keyring_);
  for (Bytes& row : *rows) {
    ENAMEL_ASSIGN_OR_RETURN(row, personal.Open(std::move(row)));
  }
  return rows;
}

Result<trace::Seal> RecordingRows::AttemptSeal(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<trace::Seal> {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kOnly));
    if (ingest.expired) return Expired(attempt);
    if (ingest.trace_blob.IsZero()) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is not sealed yet");
    }
    return trace::Seal{attempt, ingest.chunks, ingest.ticks, ingest.head, ingest.head_state_hash};
  });
}

// Reads all of it. False: it is lost, cut short, changed, or another attempt's.
Result<bool> RecordingRows::Reads(const Uuid& attempt, const Ingest& ingest) {
  const auto bytes = blobs_.GetBlob(ingest.trace_blob);
  const Code code = bytes.status().code();
  if (code == Code::kNotFound || code == Code::kStorage) return false;
  if (!bytes.ok()) return bytes.status();
  const auto file = trace::DecodeTraceFile(*bytes);
  if (!file.ok() || !file->seal) return false;
  const trace::Seal& seal = *file->seal;
  return seal.attempt == attempt && seal.chunks == ingest.chunks && seal.last_chunk == ingest.head;
}

Result<bool> RecordingRows::IsWhole(const Uuid& attempt) {
  using Clock = std::chrono::steady_clock;
  auto ingest = rows_.Read([&](Db& db) { return FindIngest(db, attempt, Look::kOnly); });
  if (!ingest.ok()) return ingest.status();
  if (ingest->trace_blob.IsZero() || ingest->expired) return true;
  const bool there = blobs_.HasBlob(ingest->trace_blob);
  {
    MutexLock lock(mutex_);
    const auto seen = seen_.find(attempt);
    if (seen != seen_.end() && seen->second.blob == ingest->trace_blob &&
        (there || !seen->second.whole)) {
      const auto age = Clock::now() - seen->second.at;
      if (seen->second.whole ? age < kLookAgain : age < kLostAgain) return seen->second.whole;
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool whole, Reads(attempt, *ingest));
  MutexLock lock(mutex_);
  if (seen_.size() >= kMostSeen) seen_.clear();
  seen_[attempt] = {ingest->trace_blob, whole, Clock::now()};
  return whole;
}

void RecordingRows::NoteWritten(const Uuid& attempt) {
  MutexLock lock(mutex_);
  seen_.erase(attempt);
}

Result<uint32_t> RecordingRows::NextChunk(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(const bool whole, IsWhole(attempt));
  return rows_.Read([&](Db& db) -> Result<uint32_t> {
    if (!whole) {
      ENAMEL_ASSIGN_OR_RETURN(const ChunkEnd end, EndOfRows(db, attempt));
      return end.next;
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto ingest, FindIngest(db, attempt, Look::kOnly));
    return ingest.chunks;
  });
}

Result<std::vector<ContradictionRow>> RecordingRows::ContradictionsOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ContradictionRow>> {
    Query q(db,
            "SELECT seq, hash, received_ms FROM contradicting_chunks WHERE tenant = ?1 AND "
            "attempt = ?2 ORDER BY seq, received_ms, hash");
    q.Bind(attempt);
    std::vector<ContradictionRow> out;
    while (q.Next()) out.push_back({static_cast<uint32_t>(q.Int(0)), q.Hash(1), q.Int(2)});
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server
