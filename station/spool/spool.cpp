#include "station/spool/spool.h"

#include <sqlite3.h>

#include "spool_schema.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr int kSchemaVersion = 1;
constexpr int kBusy_ms = 10'000;

int64_t UnixMs(std::chrono::system_clock::time_point t) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(t.time_since_epoch()).count();
}

std::string WhatToDo(int code) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return "the disk is full: free space there and start again";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return "make the folder writable for this user, or choose another with --data";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "the file is damaged: keep a copy, run 'enamel-station spool verify', and move it "
             "away";
    case SQLITE_BUSY:
      return "another enamel-station is using it: wait until that one has ended";
    default:
      return "see the system's log for this disk";
  }
}

}  // namespace

struct Spool::Db {
  fs::path file;
  sqlite3* handle = nullptr;

  ~Db() { sqlite3_close(handle); }

  Status Fail(const char* doing) const {
    int code = sqlite3_extended_errcode(handle);
    return Status(Code::kStorage, "spool " + file.string() + ": " + doing + " failed (" +
                                      sqlite3_errmsg(handle) + "); " + WhatToDo(code));
  }
  Status Exec(const char* sql, const char* doing) {
    return sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) == SQLITE_OK ? Status::Ok()
                                                                             : Fail(doing);
  }
};

namespace {

// One prepared statement; steps through its rows.
class Statement {
 public:
  Statement(sqlite3* db, const char* sql) { sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr); }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& Blob(ByteView v) {
    // Never null: an empty blob is not NULL.
    sqlite3_bind_blob(statement_, ++bound_,
                      v.empty() ? "" : reinterpret_cast<const char*>(v.data()),
                      static_cast<int>(v.size()), SQLITE_TRANSIENT);
    return *this;
  }
  Statement& Int(int64_t v) {
    sqlite3_bind_int64(statement_, ++bound_, v);
    return *this;
  }
  Statement& Text(const std::string& v) {
    sqlite3_bind_text(statement_, ++bound_, v.c_str(), -1, SQLITE_TRANSIENT);
    return *this;
  }
  // SQLITE_ROW, SQLITE_DONE or an error; an error too when the statement did not compile.
  int Step() { return statement_ == nullptr ? SQLITE_ERROR : sqlite3_step(statement_); }

  bool IsNull(int column) { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  int64_t IntAt(int column) { return sqlite3_column_int64(statement_, column); }
  std::string TextAt(int column) {
    auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text == nullptr ? "" : text;
  }
  Bytes BlobAt(int column) {
    auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column));
    return data == nullptr ? Bytes{} : Bytes(data, data + sqlite3_column_bytes(statement_, column));
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

constexpr char kSelectAttempts[] =
    "SELECT a.id, a.exercise, a.profile, a.created_unix_ms, a.seal_chunks, a.seal_ticks,"
    " a.seal_last_sha256, a.seal_state_hash, a.sealed_at_server, a.refused,"
    " count(c.seq), count(c.committed_unix_ms), coalesce(sum(c.ticks), 0),"
    " coalesce(sum(c.gap_ticks), 0), coalesce(sum(length(c.bytes)), 0)"
    " FROM attempts a LEFT JOIN chunks c ON c.attempt = a.id"
    " WHERE ?1 IS NULL OR a.id = ?1 GROUP BY a.id ORDER BY a.created_unix_ms, a.id";

SpooledAttempt ReadAttempt(Statement& row) {
  SpooledAttempt out;
  if (Bytes id = row.BlobAt(0); id.size() == 16) out.id = Uuid::FromBytes(id);
  out.exercise = row.TextAt(1);
  out.profile = row.TextAt(2);
  out.created_unix_ms = row.IntAt(3);
  if (Bytes last = row.BlobAt(6); !row.IsNull(4) && last.size() == 32) {
    out.seal = trace::Seal{out.id, static_cast<uint32_t>(row.IntAt(4)),
                           static_cast<uint64_t>(row.IntAt(5)), Sha256::FromBytes(last),
                           static_cast<uint64_t>(row.IntAt(7))};
  }
  out.sealed_at_server = row.IntAt(8) != 0;
  out.refused = row.TextAt(9);
  out.chunks = static_cast<uint32_t>(row.IntAt(10));
  out.committed = static_cast<uint32_t>(row.IntAt(11));
  out.ticks = static_cast<uint64_t>(row.IntAt(12));
  out.gap_ticks = static_cast<uint64_t>(row.IntAt(13));
  out.bytes = static_cast<uint64_t>(row.IntAt(14));
  return out;
}

Status NoAttempt(const Uuid& attempt) {
  return Status(Code::kNotFound, "the spool has no attempt " + attempt.Text() +
                                     ": 'enamel-station spool list' shows those it has");
}

// Chain, signatures and seal of a recording.
Status VerifyRecording(const SpooledAttempt& attempt, const trace::TraceFile& file,
                       const std::optional<trace::PublicKey>& key) {
  auto header = trace::DecodeHeader(file.header);
  if (!header.ok()) return header.status();
  trace::ChainVerifier chain(attempt.id, HashSha256(file.header));
  for (const Bytes& bytes : file.chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    if (!chunk.ok()) return chunk.status();
    ENAMEL_RETURN_IF_ERROR(chain.Accept(*chunk));
    if (key && !trace::VerifyChunk(bytes, *key)) {
      return Status(Code::kConflict, "chunk " + std::to_string(chunk->head.seq) +
                                         " does not carry this station's signature");
    }
  }
  return file.seal ? chain.AcceptSeal(*file.seal) : Status::Ok();
}

}  // namespace

Spool::Spool(std::unique_ptr<Db> db) : db_(std::move(db)) {}
Spool::~Spool() = default;
const fs::path& Spool::file() const { return db_->file; }

Result<std::unique_ptr<Spool>> Spool::Open(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Status(Code::kStorage, "cannot create the folder " + folder.string() + " (" +
                                      error.message() + "): choose another with --data");
  }
  auto db = std::make_unique<Db>();
  db->file = folder / "spool.sqlite";
  if (sqlite3_open_v2(db->file.c_str(), &db->handle,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX,
                      nullptr) != SQLITE_OK) {
    return db->Fail("opening");
  }
  sqlite3_busy_timeout(db->handle, kBusy_ms);
  // Recordings identify people: nobody but the owner reads them.
  fs::permissions(db->file, fs::perms::owner_read | fs::perms::owner_write, error);
  ENAMEL_RETURN_IF_ERROR(db->Exec(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON", "opening"));
  int64_t version = 0;
  {
    Statement s(db->handle, "PRAGMA user_version");
    if (s.Step() != SQLITE_ROW) return db->Fail("reading its version");
    version = s.IntAt(0);
  }
  if (version > kSchemaVersion) {
    return Status(Code::kVersion, "spool " + db->file.string() + " is of version " +
                                      std::to_string(version) + ", this program knows " +
                                      std::to_string(kSchemaVersion) +
                                      ": use the newer enamel-station that made it");
  }
  if (version == 0) {
    std::string sql =
        std::string("BEGIN IMMEDIATE;") + kSpoolSchema + "PRAGMA user_version = 1; COMMIT";
    ENAMEL_RETURN_IF_ERROR(db->Exec(sql.c_str(), "creating its tables"));
  }
  if (sqlite3_db_readonly(db->handle, "main") == 1) {
    return Status(Code::kStorage,
                  "spool " + db->file.string() + " is not writable: " + WhatToDo(SQLITE_READONLY));
  }
  return std::unique_ptr<Spool>(new Spool(std::move(db)));
}

Status Spool::BeginAttempt(const trace::Header& header, const std::string& exercise,
                           const std::string& profile) {
  std::lock_guard lock(mutex_);
  Bytes bytes = trace::EncodeHeader(header);
  Sha256 hash = HashSha256(bytes);
  ByteView id = header.ticket.attempt.view();
  {
    Statement s(db_->handle, "SELECT header_sha256 FROM attempts WHERE id = ?");
    int rc = s.Blob(id).Step();
    if (rc == SQLITE_ROW) {
      if (s.BlobAt(0) == Bytes(hash.bytes.begin(), hash.bytes.end())) return Status::Ok();
      return Status(Code::kConflict, "attempt " + header.ticket.attempt.Text() +
                                         " is in the spool with another header");
    }
    if (rc != SQLITE_DONE) return db_->Fail("reading an attempt");
  }
  Statement s(db_->handle,
              "INSERT INTO attempts (id, header, header_sha256, exercise, profile, created_unix_ms)"
              " VALUES (?, ?, ?, ?, ?, ?)");
  s.Blob(id)
      .Blob(bytes)
      .Blob(hash.view())
      .Text(exercise)
      .Text(profile)
      .Int(UnixMs(std::chrono::system_clock::now()));
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("storing an attempt");
}

Status Spool::PutChunk(const Uuid& attempt, ByteView chunk) {
  auto head = trace::DecodeChunkHead(chunk);
  if (!head.ok()) return head.status();
  if (head->head.attempt != attempt) {
    return Status(Code::kConflict, "the chunk belongs to attempt " + head->head.attempt.Text() +
                                       ", not to " + attempt.Text());
  }
  std::lock_guard lock(mutex_);
  {
    Statement s(db_->handle, "SELECT sha256 FROM chunks WHERE attempt = ? AND seq = ?");
    int rc = s.Blob(attempt.view()).Int(head->head.seq).Step();
    if (rc == SQLITE_ROW) {
      if (s.BlobAt(0) == Bytes(head->hash.bytes.begin(), head->hash.bytes.end()))
        return Status::Ok();
      return Status(Code::kConflict, "attempt " + attempt.Text() + " has another chunk " +
                                         std::to_string(head->head.seq) + " already");
    }
    if (rc != SQLITE_DONE) return db_->Fail("reading a chunk");
  }
  Statement s(db_->handle,
              "INSERT INTO chunks (attempt, seq, sha256, bytes, ticks, gap_ticks)"
              " VALUES (?, ?, ?, ?, ?, ?)");
  s.Blob(attempt.view())
      .Int(head->head.seq)
      .Blob(head->hash.view())
      .Blob(chunk)
      .Int(head->head.count)
      .Int(head->head.gap_ticks);
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("storing a chunk");
}

Status Spool::PutSeal(const trace::Seal& seal) {
  auto stored = Get(seal.attempt);
  if (!stored.ok()) return stored.status();
  if (stored->seal) {
    bool same = stored->seal->chunks == seal.chunks && stored->seal->ticks == seal.ticks &&
                stored->seal->last_chunk == seal.last_chunk &&
                stored->seal->state_hash == seal.state_hash;
    if (same) return Status::Ok();
    return Status(Code::kConflict,
                  "attempt " + seal.attempt.Text() + " is sealed otherwise already");
  }
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET seal_chunks = ?, seal_ticks = ?, seal_last_sha256 = ?,"
              " seal_state_hash = ? WHERE id = ?");
  s.Int(seal.chunks)
      .Int(static_cast<int64_t>(seal.ticks))
      .Blob(seal.last_chunk.view())
      .Int(static_cast<int64_t>(seal.state_hash))
      .Blob(seal.attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("storing a seal");
}

Status Spool::SetCommittedBelow(const Uuid& attempt, uint32_t next_seq) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE chunks SET committed_unix_ms = CASE WHEN seq < ?1"
              " THEN coalesce(committed_unix_ms, ?2) END WHERE attempt = ?3");
  s.Int(next_seq).Int(UnixMs(std::chrono::system_clock::now())).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking chunks");
}

Status Spool::MarkCommitted(const Uuid& attempt, uint32_t seq) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE chunks SET committed_unix_ms = coalesce(committed_unix_ms, ?)"
              " WHERE attempt = ? AND seq = ?");
  s.Int(UnixMs(std::chrono::system_clock::now())).Blob(attempt.view()).Int(seq);
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking a chunk");
}

Status Spool::MarkSealedAtServer(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "UPDATE attempts SET sealed_at_server = 1 WHERE id = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking a seal");
}

Status Spool::MarkRefused(const Uuid& attempt, const std::string& why) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "UPDATE attempts SET refused = ? WHERE id = ?");
  return s.Text(why).Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                                : db_->Fail("marking an attempt");
}

Result<std::vector<SpooledAttempt>> Spool::List() {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, kSelectAttempts);
  std::vector<SpooledAttempt> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) out.push_back(ReadAttempt(s));
  if (rc != SQLITE_DONE) return db_->Fail("listing attempts");
  return out;
}

Result<SpooledAttempt> Spool::Get(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, kSelectAttempts);
  int rc = s.Blob(attempt.view()).Step();
  if (rc == SQLITE_DONE) return NoAttempt(attempt);
  if (rc != SQLITE_ROW) return db_->Fail("reading an attempt");
  return ReadAttempt(s);
}

Result<Bytes> Spool::HeaderOf(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "SELECT header FROM attempts WHERE id = ?");
  int rc = s.Blob(attempt.view()).Step();
  if (rc == SQLITE_DONE) return NoAttempt(attempt);
  if (rc != SQLITE_ROW) return db_->Fail("reading a header");
  return s.BlobAt(0);
}

Result<std::vector<SpooledChunk>> Spool::ChunksFrom(const Uuid& attempt, uint32_t seq,
                                                    size_t limit) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "SELECT seq, bytes FROM chunks WHERE attempt = ? AND seq >= ? ORDER BY seq LIMIT ?");
  s.Blob(attempt.view()).Int(seq).Int(static_cast<int64_t>(limit));
  std::vector<SpooledChunk> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) {
    out.push_back({static_cast<uint32_t>(s.IntAt(0)), s.BlobAt(1)});
  }
  if (rc != SQLITE_DONE) return db_->Fail("reading chunks");
  return out;
}

Result<trace::TraceFile> Spool::Export(const Uuid& attempt) {
  auto stored = Get(attempt);
  if (!stored.ok()) return stored.status();
  auto header = HeaderOf(attempt);
  if (!header.ok()) return header.status();
  auto chunks = ChunksFrom(attempt, 0, SIZE_MAX >> 1);
  if (!chunks.ok()) return chunks.status();
  trace::TraceFile file;
  file.header = std::move(*header);
  for (SpooledChunk& chunk : *chunks) file.chunks.push_back(std::move(chunk.bytes));
  file.seal = stored->seal;
  return file;
}

Result<std::vector<SpoolVerdict>> Spool::Verify(const std::optional<trace::PublicKey>& key) {
  {
    std::lock_guard lock(mutex_);
    Statement s(db_->handle, "PRAGMA integrity_check");
    if (s.Step() != SQLITE_ROW) return db_->Fail("checking its pages");
    if (std::string found = s.TextAt(0); found != "ok") {
      return Status(Code::kStorage,
                    "spool " + db_->file.string() + ": " + found + "; " + WhatToDo(SQLITE_CORRUPT));
    }
  }
  auto attempts = List();
  if (!attempts.ok()) return attempts.status();
  std::vector<SpoolVerdict> out;
  for (SpooledAttempt& attempt : *attempts) {
    auto file = Export(attempt.id);
    Status status = file.ok() ? VerifyRecording(attempt, *file, key) : file.status();
    out.push_back({std::move(attempt), std::move(status)});
  }
  return out;
}

Result<int> Spool::Prune(std::chrono::milliseconds age, std::chrono::system_clock::time_point now) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "DELETE FROM attempts WHERE sealed_at_server = 1 AND NOT EXISTS"
              " (SELECT 1 FROM chunks c WHERE c.attempt = attempts.id AND"
              " (c.committed_unix_ms IS NULL OR c.committed_unix_ms > ?))");
  if (s.Int(UnixMs(now) - age.count()).Step() != SQLITE_DONE) return db_->Fail("pruning");
  return sqlite3_changes(db_->handle);
}

}  // namespace enamel::station
