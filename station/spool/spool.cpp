#include "station/spool/spool.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "common/base/counted.h"
#include "common/base/unix_time.h"
#include "station/spool/attempt_row.h"
#include "station/spool/spool_file.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// Every column except the header, which can be long and only Export and Verify need.
constexpr char kSelectAttempts[] =
    "SELECT id, exercise, profile, created_unix_ms, seal_chunks, seal_ticks, seal_last_sha256,"
    " seal_state_hash, sealed_at_server, refused, chunks, committed, ticks, gap_ticks, bytes, "
    "facts, resumed, refused_unix_ms, waits_because, waits_since_unix_ms, tried_unix_ms,"
    " sign_off, outline"
    " FROM attempts WHERE ?1 IS NULL OR id = ?1 ORDER BY created_unix_ms, id";

// Identifies the machine's start, and the time since, including sleep: setting a clock does not
// change it. proc(5), random/boot_id.
struct SinceBoot {
  std::string boot;
  int64_t ms = 0;
};
// CLOCK_BOOTTIME includes sleep, unlike CLOCK_MONOTONIC: a gap over night counts.
SinceBoot BootNow() {
  SinceBoot out;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> out.boot;
  timespec t{};
  clock_gettime(CLOCK_BOOTTIME, &t);
  out.ms = t.tv_sec * int64_t{1000} + t.tv_nsec / 1'000'000;
  return out;
}

}  // namespace

SpooledAttempt ReadAttemptRow(const sql::Query& row) {
  SpooledAttempt out;
  if (Bytes id = row.Blob("id"); id.size() == 16) out.id = Uuid::FromBytes(id);
  out.exercise = row.Text("exercise");
  out.profile = row.Text("profile");
  out.created_unix_ms = row.Int("created_unix_ms");
  if (Bytes last = row.Blob("seal_last_sha256"); !row.IsNull("seal_chunks") && last.size() == 32) {
    out.seal = trace::Seal{out.id, static_cast<uint32_t>(row.Int("seal_chunks")),
                           static_cast<uint64_t>(row.Int("seal_ticks")), Sha256::FromBytes(last),
                           static_cast<uint64_t>(row.Int("seal_state_hash"))};
  }
  out.sealed_at_server = row.Int("sealed_at_server") != 0;
  out.refused = row.Text("refused");
  out.chunks = static_cast<uint32_t>(row.Int("chunks"));
  out.committed = static_cast<uint32_t>(row.Int("committed"));
  out.ticks = static_cast<uint64_t>(row.Int("ticks"));
  out.gap_ticks = static_cast<uint64_t>(row.Int("gap_ticks"));
  out.bytes = static_cast<uint64_t>(row.Int("bytes"));
  // Unreadable facts must not cost the attempt: they are left empty.
  if (auto facts = protocol::DecodeFacts(row.Blob("facts")); facts.ok()) out.facts = *facts;
  out.facts.set_resumed(static_cast<uint32_t>(row.Int("resumed")));
  out.refused_unix_ms = row.Int("refused_unix_ms");
  out.waits_because = row.Text("waits_because");
  out.waits_since_unix_ms = row.Int("waits_since_unix_ms");
  out.tried_unix_ms = row.Int("tried_unix_ms");
  out.terms = {row.Int("sign_off") != 0, row.Int("outline") != 0};
  return out;
}

Status NoAttempt(const Uuid& attempt) {
  return Status(Code::kNotFound, "the spool has no attempt " + attempt.Text() +
                                     ": 'enamel-station spool list' shows those it has");
}

Spool::Spool(std::unique_ptr<SpoolFile> file)
    : file_(std::move(file)), tickets_(*file_), loop_facts_(*file_) {}
Spool::~Spool() = default;

Result<std::unique_ptr<Spool>> Spool::Open(const fs::path& folder) {
  ENAMEL_ASSIGN_OR_RETURN(auto file, SpoolFile::Open(folder));
  return std::unique_ptr<Spool>(new Spool(std::move(file)));
}

Result<std::unique_ptr<Spool>> Spool::OpenToRead(const fs::path& folder) {
  ENAMEL_ASSIGN_OR_RETURN(auto file, SpoolFile::OpenToRead(folder));
  return std::unique_ptr<Spool>(new Spool(std::move(file)));
}

const fs::path& Spool::file() const { return file_->path(); }

Status Spool::BeginAttempt(const trace::Header& header, const std::string& exercise,
                           const std::string& profile, const protocol::AttemptFacts& facts,
                           const ChairTerms& terms) {
  MutexLock lock(file_->mutex());
  Bytes bytes = trace::EncodeHeader(header);
  Sha256 hash = HashSha256(bytes);
  ByteView id = header.ticket.attempt.view();
  {
    sql::Query s(file_->db(), "SELECT header_sha256 FROM attempts WHERE id = ?");
    if (s.BindBlob(id).Next()) {
      if (s.Hash(0) == hash) return Status::Ok();
      return Status(Code::kConflict, "attempt " + header.ticket.attempt.Text() +
                                         " is in the spool with another header");
    }
    if (!s.status().ok()) return file_->Fail("reading an attempt");
  }
  sql::Query s(
      file_->db(),
      "INSERT INTO attempts (id, header, header_sha256, exercise, profile, created_unix_ms,"
      " boot_id, boot_ms, facts, resumed, sign_off, outline) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, "
      "?, ?)");
  const SinceBoot now = BootNow();
  s.BindBlob(id)
      .BindBlob(bytes)
      .BindBlob(hash.view())
      .BindText(exercise)
      .BindText(profile)
      .BindInt(UnixMs())
      .BindText(now.boot)
      .BindInt(now.ms)
      .BindBlob(protocol::EncodeFacts(facts))
      .BindInt(facts.resumed())
      .BindInt(int64_t{terms.sign_off})
      .BindInt(int64_t{terms.outline});
  return file_->Run(s, "storing an attempt");
}

Status Spool::PutChunk(const Uuid& attempt, ByteView chunk) {
  ENAMEL_ASSIGN_OR_RETURN(auto head, trace::DecodeChunkHead(chunk));
  if (head.head.attempt != attempt) {
    return Status(Code::kConflict, "the chunk belongs to attempt " + head.head.attempt.Text() +
                                       ", not to " + attempt.Text());
  }
  MutexLock lock(file_->mutex());
  {
    sql::Query s(file_->db(), "SELECT sha256 FROM chunks WHERE attempt = ? AND seq = ?");
    if (s.BindBlob(attempt.view()).BindInt(head.head.seq).Next()) {
      // Compared by the hash without the signature, which is also what the chain uses.
      if (s.Hash(0) == head.hash) return Status::Ok();
      return Status(Code::kConflict, "attempt " + attempt.Text() + " has another chunk " +
                                         std::to_string(head.head.seq) + " already");
    }
    if (!s.status().ok()) return file_->Fail("reading a chunk");
  }
  // One transaction for chunk and counts: listing attempts need not read their chunks, and the
  // counts always match.
  sql::Transaction transaction(file_->db());
  if (!transaction.begun().ok()) return file_->Fail("storing a chunk");
  {
    sql::Query s(
        file_->db(),
        "INSERT INTO chunks (attempt, seq, sha256, bytes, ticks, gap_ticks, spooled_unix_ms)"
        " VALUES (?, ?, ?, ?, ?, ?, ?)");
    s.BindBlob(attempt.view())
        .BindInt(head.head.seq)
        .BindBlob(head.hash.view())
        .BindBlob(chunk)
        .BindInt(head.head.count)
        .BindInt(head.head.gap_ticks)
        .BindInt(UnixMs());
    ENAMEL_RETURN_IF_ERROR(file_->Run(s, "storing a chunk"));
  }
  {
    sql::Query s(
        file_->db(),
        "UPDATE attempts SET chunks = chunks + 1, ticks = ticks + ?, gap_ticks = gap_ticks + ?,"
        " bytes = bytes + ?, boot_id = ?, boot_ms = ? WHERE id = ?");
    const SinceBoot now = BootNow();
    s.BindInt(head.head.count)
        .BindInt(head.head.gap_ticks)
        .BindInt(static_cast<int64_t>(chunk.size()))
        .BindText(now.boot)
        .BindInt(now.ms)
        .BindBlob(attempt.view());
    ENAMEL_RETURN_IF_ERROR(file_->Run(s, "counting a chunk"));
  }
  return transaction.Commit().ok() ? Status::Ok() : file_->Fail("storing a chunk");
}

Status Spool::MarkResumed(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               // In the database, not in memory, so that a crash during the resumption counts too.
               "UPDATE attempts SET resumed = resumed + 1 WHERE id = ? AND seal_chunks IS NULL");
  ENAMEL_RETURN_IF_ERROR(file_->Run(s.BindBlob(attempt.view()), "resuming an attempt"));
  if (file_->db().Changes() == 1) return Status::Ok();
  return Status(Code::kConflict,
                "attempt " + attempt.Text() + " has ended (or is not here): it cannot be resumed");
}

Result<trace::Seal> Spool::CloseAttempt(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto stored, Get(attempt));
  if (stored.seal) return *stored.seal;
  if (stored.chunks == 0) {
    return Status(Code::kInvalidInput,
                  "of attempt " + attempt.Text() +
                      " not one chunk is here: it ended before anything was recorded");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto last, ChunksFrom(attempt, stored.chunks - 1, 1));
  ENAMEL_ASSIGN_OR_RETURN(auto chunk, last.empty() ? Result<trace::Chunk>(NoAttempt(attempt))
                                                   : trace::DecodeChunkHead(last.front().bytes));
  // Only from the last chunk: its head has the end of the chain, and each was checked when stored.
  trace::Seal seal{attempt, stored.chunks, chunk.head.first_tick + chunk.head.count, chunk.hash,
                   chunk.head.state_hash};
  ENAMEL_RETURN_IF_ERROR(PutSeal(seal));
  return seal;
}

Status Spool::PutSeal(const trace::Seal& seal) {
  ENAMEL_ASSIGN_OR_RETURN(auto stored, Get(seal.attempt));
  if (stored.seal) {
    bool same = stored.seal->chunks == seal.chunks && stored.seal->ticks == seal.ticks &&
                stored.seal->last_chunk == seal.last_chunk &&
                stored.seal->state_hash == seal.state_hash;
    if (same) return Status::Ok();
    return Status(Code::kConflict,
                  "attempt " + seal.attempt.Text() + " is sealed otherwise already");
  }
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET seal_chunks = ?, seal_ticks = ?, seal_last_sha256 = ?,"
               " seal_state_hash = ? WHERE id = ?");
  s.BindInt(seal.chunks)
      .BindInt(static_cast<int64_t>(seal.ticks))
      .BindBlob(seal.last_chunk.view())
      .BindInt(static_cast<int64_t>(seal.state_hash))
      .BindBlob(seal.attempt.view());
  return file_->Run(s, "storing a seal");
}

Status Spool::SetCommittedBelow(const Uuid& attempt, uint32_t next_seq) {
  MutexLock lock(file_->mutex());
  sql::Query s(
      file_->db(),
      // Writes only changes: each write waits for the disk, and delays a chunk being recorded.
      "UPDATE attempts SET committed = min(?1, chunks), committed_unix_ms = ?2"
      " WHERE id = ?3 AND committed != min(?1, chunks)");
  s.BindInt(next_seq).BindInt(UnixMs()).BindBlob(attempt.view());
  return file_->Run(s, "marking chunks");
}

Status Spool::MarkCommitted(const Uuid& attempt, uint32_t seq) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET committed = ?1, committed_unix_ms = ?2"
               " WHERE id = ?3 AND committed < ?1");
  // Acknowledgements come in order, and one write marks several: the last includes the others.
  s.BindInt(int64_t{seq} + 1).BindInt(UnixMs()).BindBlob(attempt.view());
  return file_->Run(s, "marking a chunk");
}

Status Spool::MarkWanted(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  // Its chunks stay counted as committed until OpenAttempt says where to start.
  sql::Query s(file_->db(), "UPDATE attempts SET sealed_at_server = 0 WHERE id = ?");
  return file_->Run(s.BindBlob(attempt.view()), "marking an attempt");
}

Status Spool::MarkSealedAtServer(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET sealed_at_server = 1, committed_unix_ms = ? WHERE id = ?");
  s.BindInt(UnixMs());
  return file_->Run(s.BindBlob(attempt.view()), "marking a seal");
}

// Success writes only if an earlier failure is to be cleared.
Status Spool::MarkTried(const Uuid& attempt, const std::string& problem) {
  if (!problem.empty()) return MarkTriedWhere("id = ?3", attempt, problem);
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET waits_because = NULL, waits_since_unix_ms = NULL,"
               " tried_unix_ms = NULL WHERE id = ? AND waits_because IS NOT NULL");
  return file_->Run(s.BindBlob(attempt.view()), "marking an attempt");
}

Status Spool::MarkAllTried(const std::string& problem) {
  return MarkTriedWhere(
      // As SpooledAttempt::waits; `?3 IS NOT NULL` only uses the bound parameter.
      "refused IS NULL AND (committed < chunks OR (seal_chunks IS NOT NULL AND NOT "
      "sealed_at_server)) AND ?3 IS NOT NULL",
      {}, problem);
}

Status Spool::MarkTriedWhere(const char* where, const Uuid& attempt, const std::string& problem) {
  MutexLock lock(file_->mutex());
  const std::string sql =
      "UPDATE attempts SET waits_because = ?1, tried_unix_ms = ?2,"
      " waits_since_unix_ms = coalesce(waits_since_unix_ms, ?2) WHERE " +
      std::string(where);
  sql::Query s(file_->db(), sql.c_str());
  s.BindText(problem).BindInt(UnixMs()).BindBlob(attempt.view());
  return file_->Run(s, "marking what waits");
}

// A refusal outweighs failed tries: why it waits no longer matters.
Status Spool::MarkRefused(const Uuid& attempt, const std::string& why) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET refused = ?, refused_unix_ms = ?, waits_because = NULL,"
               " waits_since_unix_ms = NULL, tried_unix_ms = NULL WHERE id = ?");
  return file_->Run(s.BindText(why).BindInt(UnixMs()).BindBlob(attempt.view()),
                    "marking an attempt");
}

Status Spool::ClearRefusal(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "UPDATE attempts SET refused = NULL, refused_unix_ms = NULL WHERE id = ?");
  return file_->Run(s.BindBlob(attempt.view()), "marking an attempt");
}

Result<std::vector<SpooledAttempt>> Spool::List() {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(), kSelectAttempts);
  s.BindNull(sql::Type::kBlob);  // all of them
  std::vector<SpooledAttempt> out;
  while (s.Next()) out.push_back(ReadAttemptRow(s));
  if (!s.status().ok()) return file_->Fail("listing attempts");
  return out;
}

Result<SpooledAttempt> Spool::Get(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(), kSelectAttempts);
  const bool there = s.BindBlob(attempt.view()).Next();
  if (!s.status().ok()) return file_->Fail("reading an attempt");
  if (!there) return NoAttempt(attempt);
  return ReadAttemptRow(s);
}

Result<Bytes> Spool::HeaderOf(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(), "SELECT header FROM attempts WHERE id = ?");
  const bool there = s.BindBlob(attempt.view()).Next();
  if (!s.status().ok()) return file_->Fail("reading a header");
  if (!there) return NoAttempt(attempt);
  return s.Blob(0);
}

Result<std::vector<SpooledChunk>> Spool::ChunksFrom(const Uuid& attempt, uint32_t seq,
                                                    size_t limit) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "SELECT seq, bytes FROM chunks WHERE attempt = ? AND seq >= ? ORDER BY seq LIMIT ?");
  s.BindBlob(attempt.view()).BindInt(seq).BindInt(static_cast<int64_t>(limit));
  std::vector<SpooledChunk> out;
  while (s.Next()) {
    out.push_back({static_cast<uint32_t>(s.Int(0)), s.Blob(1)});
  }
  if (!s.status().ok()) return file_->Fail("reading chunks");
  return out;
}

// Also without a seal, to examine an interrupted recording.
Result<trace::TraceFile> Spool::Export(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto stored, Get(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, ChunksFrom(attempt, 0, SIZE_MAX >> 1));
  trace::TraceFile file;
  file.header = std::move(header);
  for (SpooledChunk& chunk : chunks) file.chunks.push_back(std::move(chunk.bytes));
  file.seal = stored.seal;
  return file;
}

Result<Silence> Spool::SilenceOf(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "SELECT coalesce((SELECT spooled_unix_ms FROM chunks WHERE attempt = ?1"
               " ORDER BY seq DESC LIMIT 1), created_unix_ms), boot_id, boot_ms"
               " FROM attempts WHERE id = ?1");
  const bool there = s.BindBlob(attempt.view()).Next();
  if (!s.status().ok()) return file_->Fail("reading when an attempt was recorded last");
  if (!there) return NoAttempt(attempt);
  constexpr int64_t kStepped_ms = 1000;
  const SinceBoot now = BootNow();
  // Two measures that fail differently: the clock can be set, uptime ends with a restart. Each
  // failure only makes its measure too short, so the longer one is right.
  const int64_t by_clock_ms = UnixMs() - s.Int(0);
  Silence out{std::max<int64_t>(by_clock_ms, 0), by_clock_ms < -kStepped_ms};
  if (s.Text(1) == now.boot) {
    const int64_t by_boot_ms = now.ms - s.Int(2);
    out.clock_stepped |= by_boot_ms - by_clock_ms > kStepped_ms;
    out.ms = std::max(out.ms, by_boot_ms);
  }
  return out;
}

Result<std::optional<int64_t>> Spool::LastSpooledUnixMs(const Uuid& attempt) {
  MutexLock lock(file_->mutex());
  sql::Query s(file_->db(),
               "SELECT spooled_unix_ms FROM chunks WHERE attempt = ? ORDER BY seq DESC LIMIT 1");
  const bool there = s.BindBlob(attempt.view()).Next();
  if (!s.status().ok()) return file_->Fail("reading a chunk's time");
  if (!there) return std::optional<int64_t>();
  return std::optional<int64_t>(s.Int(0));
}

std::string PrunedText(const Pruned& pruned, const Retention& retention) {
  if (pruned.early == 0) return {};
  return Counted(pruned.early, "recording that the server has was",
                 "recordings that the server has were") +
         " forgotten here before their time, as the spool may "
         "take " +
         std::to_string(retention.bytes / 1'000'000) +
         " MB only: a server restored from an older backup cannot get them back from here";
}

Result<Pruned> Spool::Prune(const Retention& retention, std::chrono::system_clock::time_point now) {
  const int64_t old_ms =
      UnixMs(now) - std::chrono::duration_cast<std::chrono::milliseconds>(retention.age).count();
  MutexLock lock(file_->mutex());
  std::vector<std::pair<Bytes, bool>> going;  // id, early
  {
    // Newest first: those that fit stay.
    sql::Query s(file_->db(),
                 "SELECT id, bytes, committed_unix_ms, sealed_at_server AND committed >= chunks"
                 " FROM attempts ORDER BY sealed_at_server AND committed >= chunks,"
                 " committed_unix_ms DESC, id DESC");
    uint64_t kept = 0;
    while (s.Next()) {
      kept += static_cast<uint64_t>(s.Int(1));
      if (s.Int(3) == 0) continue;  // the server does not have it
      // Deletes only whole attempts, with their chunks (ON DELETE CASCADE): half a recording proves
      // nothing.
      bool old = s.Int(2) <= old_ms;
      if (old || (retention.bytes > 0 && kept > retention.bytes))
        going.push_back({s.Blob(0), !old});
    }
    if (!s.status().ok()) return file_->Fail("looking for what may go");
  }
  Pruned out;
  for (const auto& [id, early] : going) {
    sql::Query s(file_->db(), "DELETE FROM attempts WHERE id = ?");
    ENAMEL_RETURN_IF_ERROR(file_->Run(s.BindBlob(id), "pruning"));
    ++out.attempts;
    if (early) ++out.early;
  }
  return out;
}

RecordingLock::~RecordingLock() {
  if (file_ >= 0) ::close(file_);
}

Status Spool::ProveWritable(uint64_t room_bytes) {
  const fs::path folder = file_->path().parent_path();
  // f_bavail, not f_bfree: the last blocks are reserved for root, and this program is not root.
  struct statvfs space {};
  uint64_t free_bytes = 0;
  if (::statvfs(folder.c_str(), &space) == 0) {
    free_bytes = static_cast<uint64_t>(space.f_bavail) * space.f_frsize;
  }
  if (free_bytes < room_bytes) {
    auto mb = [](uint64_t bytes) {
      char text[32];
      std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) * 1e-6);
      return std::string(text);
    };
    return Status(Code::kStorage, "the disk of " + folder.string() + " has " + mb(free_bytes) +
                                      " free, and a recording needs " + mb(room_bytes) +
                                      ": free space there, then begin again");
  }
  MutexLock lock(file_->mutex());
  return file_->TestWrite();
}

Result<RecordingLock> Spool::LockForRecording() {
  fs::path path = file_->path().parent_path() / "recording.lock";
  int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) {
    return Status(Code::kStorage, "cannot open " + path.string() + " (" + std::strerror(errno) +
                                      "): " + WhatToDoAbout(SpoolTrouble::kNotWritable));
  }
  RecordingLock lock(file);
  // flock instead of a row or a file: the system releases it when the process dies, so no lock is
  // ever left behind.
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return lock;
  return Status(Code::kConflict, "another enamel-station is recording into " +
                                     path.parent_path().string() +
                                     ": end that one first, or use a folder of its own (--data)");
}

}  // namespace enamel::station
