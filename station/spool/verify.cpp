#include "station/spool/verify.h"

#include "common/base/counted.h"
#include "station/spool/spool_file.h"

namespace enamel::station {
namespace {

Status Differs(const char* what, uint64_t counted, uint64_t found) {
  return Status(Code::kConflict, std::string(what) + ": the spool counts " +
                                     std::to_string(counted) + ", there are " +
                                     std::to_string(found));
}

// Checks chain, signatures and seal of a recording, and the spool's counts.
Status VerifyRecording(const SpooledAttempt& attempt, ByteView header,
                       const std::vector<SpooledChunk>& chunks,
                       const std::optional<trace::PublicKey>& key) {
  ENAMEL_ASSIGN_OR_RETURN(auto decoded, trace::DecodeHeader(header));
  if (decoded.ticket.attempt != attempt.id) {
    return Status(Code::kConflict,
                  "its header is that of attempt " + decoded.ticket.attempt.Text());
  }
  // The same checks as the server's: it will not refuse the bytes of what passes here.
  trace::ChainVerifier chain(attempt.id, HashSha256(header));
  uint64_t ticks = 0, gap_ticks = 0, bytes = 0;
  for (const SpooledChunk& spooled : chunks) {
    auto chunk = trace::DecodeChunk(spooled.bytes);
    if (!chunk.ok()) {
      return Status(chunk.status().code(),
                    "chunk " + std::to_string(spooled.seq) + ": " + chunk.status().message());
    }
    ENAMEL_RETURN_IF_ERROR(chain.Accept(*chunk));
    if (key && !trace::VerifyChunk(spooled.bytes, *key)) {
      return Status(Code::kConflict, "chunk " + std::to_string(spooled.seq) +
                                         " does not carry this station's signature");
    }
    ticks += chunk->head.count;
    gap_ticks += chunk->head.gap_ticks;
    bytes += spooled.bytes.size();
  }
  // The counts last: where the chain is broken they differ as a consequence.
  if (chunks.size() != attempt.chunks) return Differs("chunks", attempt.chunks, chunks.size());
  if (ticks != attempt.ticks) return Differs("ticks", attempt.ticks, ticks);
  if (gap_ticks != attempt.gap_ticks) return Differs("gap ticks", attempt.gap_ticks, gap_ticks);
  if (bytes != attempt.bytes) return Differs("bytes", attempt.bytes, bytes);
  if (attempt.committed > attempt.chunks) {
    return Differs("chunks the server has", attempt.committed, attempt.chunks);
  }
  return attempt.seal ? chain.AcceptSeal(*attempt.seal) : Status::Ok();
}

Status VerifyPages(SpoolFile& file) {
  MutexLock lock(file.mutex());
  {
    // The first finding is enough: all faults of a page are salvaged in the same way.
    sql::Query s(file.db(), "PRAGMA integrity_check(1)");
    if (!s.Next()) return file.Fail("checking its pages");
    if (std::string found = s.Text(0); found != "ok") {
      return Status(Code::kStorage, "spool " + file.path().string() + ": " + found + "; " +
                                        WhatToDoAbout(SpoolTrouble::kDamaged));
    }
  }
  sql::Query s(
      file.db(),
      // A lost row of `attempts` leaves its chunks behind; foreign keys are only checked when
      // writing.
      "SELECT count(*) FROM chunks WHERE attempt NOT IN (SELECT id FROM attempts)");
  if (!s.Next()) return file.Fail("checking its chunks");
  if (s.Int(0) == 0) return Status::Ok();
  return Status(Code::kStorage, "spool " + file.path().string() + ": " +
                                    Counted(s.Int(0), "chunk is", "chunks are") +
                                    " of attempts that are not there");
}

Status VerifyAttempt(Spool& spool, const SpooledAttempt& attempt,
                     const std::optional<trace::PublicKey>& key) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, spool.HeaderOf(attempt.id));
  {
    SpoolFile& file = spool.spool_file();
    MutexLock lock(file.mutex());
    sql::Query s(file.db(), "SELECT header_sha256 FROM attempts WHERE id = ?");
    if (!s.BindBlob(attempt.id.view()).Next()) return file.Fail("reading a header's hash");
    const Sha256 hash = HashSha256(header);
    // Every chunk is chained to this hash: a header changed by one bit has lost its recording.
    if (s.Hash(0) != hash) {
      return Status(Code::kConflict, "its header is not the one whose hash is kept beside it");
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, spool.ChunksFrom(attempt.id, 0, SIZE_MAX >> 1));
  return VerifyRecording(attempt, header, chunks, key);
}

}  // namespace

Result<std::vector<SpoolVerdict>> VerifyRecordings(Spool& spool,
                                                   const std::optional<trace::PublicKey>& key,
                                                   Status* pages) {
  Status found = VerifyPages(spool.spool_file());
  if (pages != nullptr)
    *pages = found;
  else
    ENAMEL_RETURN_IF_ERROR(found);
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, spool.List());
  std::vector<SpoolVerdict> out;
  for (SpooledAttempt& attempt : attempts) {
    Status status = VerifyAttempt(spool, attempt, key);
    out.push_back({std::move(attempt), std::move(status)});
  }
  return out;
}

}  // namespace enamel::station
