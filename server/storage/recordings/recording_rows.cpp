#include "server/storage/recordings/recording_rows.h"

#include <algorithm>
#include <deque>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/storage/engine/query.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/trace_parts.h"
#include "server/storage/recordings/trace_rows.h"

namespace enamel::server {
Result<Bytes> RecordingRows::AttemptHeader(const Uuid& attempt) {
  return rows_.Read([&](Db& db) { return HeaderOf(db, attempt); });
}

namespace {

PartsReader PartsIn(StoredBlobs& blobs, TraceBlobs named) {
  return {std::move(named), [&blobs](const Sha256& hash) { return blobs.GetBlob(hash); }};
}

// Rows of chunks in order, a few in memory at a time.
class RowsReader {
 public:
  RowsReader(Transactions& rows, Keyring& keyring, const Uuid& attempt, uint32_t from,
             uint32_t chunks)
      : rows_(rows), personal_(keyring), attempt_(attempt), next_(from), chunks_(chunks) {}

  uint32_t next() const { return next_; }
  Result<std::optional<Bytes>> Next() {
    if (next_ >= chunks_) return std::optional<Bytes>();
    if (page_.empty()) {
      auto page = rows_.Read([&](Db& db) { return ChunkRowsFrom(db, attempt_, next_); });
      ENAMEL_RETURN_IF_ERROR(page.status());
      page_.assign(std::make_move_iterator(page->begin()), std::make_move_iterator(page->end()));
    }
    if (page_.empty()) {
      return Status(Code::kUnavailable, "chunk " + std::to_string(next_) + " of attempt " +
                                            attempt_.Text() + " is no longer there; try again");
    }
    Bytes row = std::move(page_.front());
    page_.pop_front();
    ++next_;
    ENAMEL_ASSIGN_OR_RETURN(auto opened, personal_.Open(std::move(row)));
    return std::optional<Bytes>(std::move(opened));
  }

 private:
  Transactions& rows_;
  PersonalReader personal_;
  const Uuid attempt_;
  uint32_t next_;
  const uint32_t chunks_;
  std::deque<Bytes> page_;
};

}  // namespace

Result<OpenRecording> RecordingRows::Open(const Uuid& attempt, uint32_t from) {
  Ingest ingest;
  TraceBlobs blobs;
  Bytes header;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(ingest, FindIngest(db, attempt, Look::kOnly));
    if (ingest.expired) return Expired(attempt);
    if (ingest.trace_blob.IsZero()) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(blobs.parts, PartsOf(db, attempt));
    blobs.last = ingest.trace_blob;
    ENAMEL_ASSIGN_OR_RETURN(header, HeaderOf(db, attempt));
    return Status::Ok();
  }));
  OpenRecording out{ingest.chunks, ingest.trace_bytes, !ingest.trace_blob.IsZero(), {}};
  if (out.sealed) {
    auto parts = std::make_shared<PartsReader>(PartsIn(blobs_, std::move(blobs)));
    parts->SkipTo(from, std::move(header));
    out.next = [parts] { return parts->Next(); };
    return out;
  }
  auto reader = std::make_shared<RowsReader>(rows_, keyring_, attempt, from, ingest.chunks);
  auto sealed = std::make_shared<trace::NextChunk>();
  out.next = [this, attempt, reader, sealed]() -> Result<std::optional<Bytes>> {
    if (*sealed) return (*sealed)();
    auto next = reader->Next();
    if (next.status().code() != Code::kUnavailable) return next;
    // Another connection has sealed it: the rest is in the blobs.
    ENAMEL_ASSIGN_OR_RETURN(auto again, Open(attempt, reader->next()));
    if (!again.sealed) return next;
    *sealed = std::move(again.next);
    return (*sealed)();
  };
  return out;
}

trace::NextChunk RecordingRows::OpenRows(const Uuid& attempt, uint32_t chunks) {
  auto reader = std::make_shared<RowsReader>(rows_, keyring_, attempt, 0, chunks);
  return [reader] { return reader->Next(); };
}

Result<std::vector<Bytes>> RecordingRows::NewestChunks(const Uuid& attempt, uint32_t from,
                                                       uint32_t most) {
  auto rows = rows_.Read([&](Db& db) -> Result<std::vector<Bytes>> {
    Query q(
        db,
        "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq >= ?3 ORDER BY "
        "seq DESC LIMIT ?4");
    return q.Bind(attempt, from, most).All<Bytes>();
  });
  ENAMEL_RETURN_IF_ERROR(rows.status());
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
Result<bool> RecordingRows::Reads(const Uuid& attempt, const Ingest& ingest,
                                  const TraceBlobs& blobs) {
  PartsReader parts = PartsIn(blobs_, blobs);
  for (;;) {
    const auto chunk = parts.Next();
    const Code code = chunk.status().code();
    if (code == Code::kNotFound || code == Code::kStorage) return false;
    ENAMEL_RETURN_IF_ERROR(chunk.status());
    if (!*chunk) break;
  }
  const trace::Seal& seal = *parts.seal();
  return seal.attempt == attempt && seal.chunks == ingest.chunks && seal.last_chunk == ingest.head;
}

Result<bool> RecordingRows::IsWhole(const Uuid& attempt) {
  using Clock = std::chrono::steady_clock;
  TraceBlobs blobs;
  auto ingest = rows_.Read([&](Db& db) -> Result<Ingest> {
    ENAMEL_ASSIGN_OR_RETURN(blobs.parts, PartsOf(db, attempt));
    return FindIngest(db, attempt, Look::kOnly);
  });
  ENAMEL_RETURN_IF_ERROR(ingest.status());
  if (ingest->trace_blob.IsZero() || ingest->expired) return true;
  blobs.last = ingest->trace_blob;
  const bool there =
      std::ranges::all_of(blobs.All(), [&](const Sha256& blob) { return blobs_.HasBlob(blob); });
  {
    MutexLock lock(mutex_);
    const auto seen = seen_.find(attempt);
    if (seen != seen_.end() && seen->second.blob == ingest->trace_blob &&
        (there || !seen->second.whole)) {
      const auto age = Clock::now() - seen->second.at;
      if (seen->second.whole ? age < kLookAgain : age < kLostAgain) return seen->second.whole;
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool whole, Reads(attempt, *ingest, blobs));
  MutexLock lock(mutex_);
  if (seen_.size() >= kMaxSeen) seen_.clear();
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
    return q.Bind(attempt).All<ContradictionRow>();
  });
}

}  // namespace enamel::server
