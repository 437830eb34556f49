#include "station/spool/spool.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "spool_schema.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr int kSchemaVersion = 2;
constexpr int kBusy_ms = 10'000, kWalRetry_ms = 10;

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
  Status UseWal();
  Result<int64_t> Version();
  // Creates the tables, or migrates them; nothing when another process has done it meanwhile.
  Status BringUpToDate();
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

// All of a transaction or nothing: what is not committed is rolled back.
class Transaction {
 public:
  explicit Transaction(sqlite3* db) : db_(db) {
    open_ = sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) == SQLITE_OK;
  }
  ~Transaction() {
    if (open_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  bool open() const { return open_; }
  bool Commit() {
    if (sqlite3_exec(db_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK) return false;
    open_ = false;
    return true;
  }

 private:
  sqlite3* db_;
  bool open_ = false;
};

constexpr char kSelectAttempts[] =
    "SELECT id, exercise, profile, created_unix_ms, seal_chunks, seal_ticks, seal_last_sha256,"
    " seal_state_hash, sealed_at_server, refused, chunks, committed, ticks, gap_ticks, bytes, "
    "resumed"
    " FROM attempts WHERE ?1 IS NULL OR id = ?1 ORDER BY created_unix_ms, id";

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
  out.resumed = static_cast<uint32_t>(row.IntAt(15));
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

// Two processes that switch a new file to WAL at once: SQLite tells one that it is locked without
// waiting the busy timeout.
Status Spool::Db::UseWal() {
  for (int waited_ms = 0;; waited_ms += kWalRetry_ms) {
    Status done = Exec("PRAGMA journal_mode = WAL", "opening");
    bool busy = !done.ok() && sqlite3_errcode(handle) == SQLITE_BUSY;
    if (!busy || waited_ms >= kBusy_ms) return done;
    sqlite3_sleep(kWalRetry_ms);
  }
}

Result<int64_t> Spool::Db::Version() {
  Statement s(handle, "PRAGMA user_version");
  if (s.Step() != SQLITE_ROW) return Fail("reading its version");
  return s.IntAt(0);
}

Status Spool::Db::BringUpToDate() {
  ENAMEL_RETURN_IF_ERROR(Exec("BEGIN IMMEDIATE", "beginning to create its tables"));
  auto version = Version();
  Status done = version.status();
  if (version.ok() && *version < kSchemaVersion) {
    std::string sql = std::string(*version == 0 ? kSpoolSchema : kSpoolFrom1) +
                      "PRAGMA user_version = " + std::to_string(kSchemaVersion);
    done = Exec(sql.c_str(), *version == 0 ? "creating its tables" : "bringing it to version 2");
  }
  if (done.ok()) return Exec("COMMIT", "creating its tables");
  (void)Exec("ROLLBACK", "going back");
  return done;
}

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
  ENAMEL_RETURN_IF_ERROR(db->UseWal());
  ENAMEL_RETURN_IF_ERROR(
      db->Exec("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON", "opening"));
  auto version = db->Version();
  if (!version.ok()) return version.status();
  if (*version > kSchemaVersion) {
    return Status(Code::kVersion, "spool " + db->file.string() + " is of version " +
                                      std::to_string(*version) + ", this program knows " +
                                      std::to_string(kSchemaVersion) +
                                      ": use the newer enamel-station that made it");
  }
  if (*version < kSchemaVersion) ENAMEL_RETURN_IF_ERROR(db->BringUpToDate());
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
  Transaction transaction(db_->handle);
  if (!transaction.open()) return db_->Fail("storing a chunk");
  {
    Statement s(
        db_->handle,
        "INSERT INTO chunks (attempt, seq, sha256, bytes, ticks, gap_ticks, spooled_unix_ms)"
        " VALUES (?, ?, ?, ?, ?, ?, ?)");
    s.Blob(attempt.view())
        .Int(head->head.seq)
        .Blob(head->hash.view())
        .Blob(chunk)
        .Int(head->head.count)
        .Int(head->head.gap_ticks)
        .Int(UnixMs(std::chrono::system_clock::now()));
    if (s.Step() != SQLITE_DONE) return db_->Fail("storing a chunk");
  }
  {
    Statement s(
        db_->handle,
        "UPDATE attempts SET chunks = chunks + 1, ticks = ticks + ?, gap_ticks = gap_ticks + ?,"
        " bytes = bytes + ? WHERE id = ?");
    s.Int(head->head.count)
        .Int(head->head.gap_ticks)
        .Int(static_cast<int64_t>(chunk.size()))
        .Blob(attempt.view());
    if (s.Step() != SQLITE_DONE) return db_->Fail("counting a chunk");
  }
  return transaction.Commit() ? Status::Ok() : db_->Fail("storing a chunk");
}

Status Spool::MarkResumed(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET resumed = resumed + 1 WHERE id = ? AND seal_chunks IS NULL");
  if (s.Blob(attempt.view()).Step() != SQLITE_DONE) return db_->Fail("resuming an attempt");
  if (sqlite3_changes(db_->handle) == 1) return Status::Ok();
  return Status(Code::kConflict,
                "attempt " + attempt.Text() + " has ended (or is not here): it cannot be resumed");
}

Result<trace::Seal> Spool::CloseAttempt(const Uuid& attempt) {
  auto stored = Get(attempt);
  if (!stored.ok()) return stored.status();
  if (stored->seal) return *stored->seal;
  if (stored->chunks == 0) {
    return Status(Code::kInvalidInput,
                  "of attempt " + attempt.Text() +
                      " not one chunk is here: it ended before anything was recorded");
  }
  auto last = ChunksFrom(attempt, stored->chunks - 1, 1);
  if (!last.ok()) return last.status();
  auto chunk = last->empty() ? Result<trace::Chunk>(NoAttempt(attempt))
                             : trace::DecodeChunkHead(last->front().bytes);
  if (!chunk.ok()) return chunk.status();
  trace::Seal seal{attempt, stored->chunks, chunk->head.first_tick + chunk->head.count, chunk->hash,
                   chunk->head.state_hash};
  ENAMEL_RETURN_IF_ERROR(PutSeal(seal));
  return seal;
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
              "UPDATE attempts SET committed = min(?1, chunks), committed_unix_ms = ?2"
              " WHERE id = ?3 AND committed != min(?1, chunks)");
  s.Int(next_seq).Int(UnixMs(std::chrono::system_clock::now())).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking chunks");
}

Status Spool::MarkCommitted(const Uuid& attempt, uint32_t seq) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET committed = ?1, committed_unix_ms = ?2"
              " WHERE id = ?3 AND committed < ?1");
  s.Int(int64_t{seq} + 1).Int(UnixMs(std::chrono::system_clock::now())).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking a chunk");
}

Status Spool::MarkWanted(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "UPDATE attempts SET sealed_at_server = 0 WHERE id = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("marking an attempt");
}

Status Spool::MarkSealedAtServer(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET sealed_at_server = 1, committed_unix_ms = ? WHERE id = ?");
  s.Int(UnixMs(std::chrono::system_clock::now()));
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

Status Spool::PutTicket(const LockedTicket& ticket) {
  std::lock_guard lock(mutex_);
  Statement s(
      db_->handle,
      "INSERT INTO tickets (attempt, person, exercise, title, profile, expires_unix_ms, salt,"
      " locked) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  s.Blob(ticket.attempt.view())
      .Text(ticket.person)
      .Text(ticket.exercise)
      .Text(ticket.title)
      .Text(ticket.profile)
      .Int(ticket.expires_unix_ms)
      .Blob(ticket.salt)
      .Blob(ticket.locked);
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("storing a ticket");
}

Result<std::vector<LockedTicket>> Spool::Tickets() {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "SELECT attempt, person, exercise, title, profile, expires_unix_ms, salt, locked,"
              " wrong_pins, wait_unix_ms FROM tickets ORDER BY attempt");
  std::vector<LockedTicket> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) {
    LockedTicket t;
    t.attempt = Uuid::FromBytes(s.BlobAt(0));
    t.person = s.TextAt(1);
    t.exercise = s.TextAt(2);
    t.title = s.TextAt(3);
    t.profile = s.TextAt(4);
    t.expires_unix_ms = s.IntAt(5);
    Bytes salt = s.BlobAt(6);
    std::copy_n(salt.begin(), std::min(salt.size(), t.salt.size()), t.salt.begin());
    t.locked = s.BlobAt(7);
    t.wrong_pins = static_cast<int>(s.IntAt(8));
    t.wait_unix_ms = s.IntAt(9);
    out.push_back(std::move(t));
  }
  if (rc != SQLITE_DONE) return db_->Fail("listing tickets");
  return out;
}

Status Spool::HandBackTicket(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE tickets SET locked = x'', salt = zeroblob(16) WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("handing back a ticket");
}

Status Spool::NoteWrongPin(const Uuid& attempt, int wrong_pins, int64_t wait_unix_ms) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "UPDATE tickets SET wrong_pins = ?, wait_unix_ms = ? WHERE attempt = ?");
  s.Int(wrong_pins).Int(wait_unix_ms).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("counting a wrong PIN");
}

Status Spool::RemoveTicket(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "DELETE FROM tickets WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("removing a ticket");
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

Result<std::optional<int64_t>> Spool::LastSpooledUnixMs(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "SELECT spooled_unix_ms FROM chunks WHERE attempt = ? ORDER BY seq DESC LIMIT 1");
  int rc = s.Blob(attempt.view()).Step();
  if (rc != SQLITE_ROW && rc != SQLITE_DONE) return db_->Fail("reading a chunk's time");
  if (rc == SQLITE_DONE || s.IsNull(0)) return std::optional<int64_t>();
  return std::optional<int64_t>(s.IntAt(0));
}

Result<Pruned> Spool::Prune(const Retention& retention, std::chrono::system_clock::time_point now) {
  const int64_t old_ms =
      UnixMs(now) - std::chrono::duration_cast<std::chrono::milliseconds>(retention.age).count();
  std::lock_guard lock(mutex_);
  std::vector<std::pair<Bytes, bool>> going;  // id, early
  {
    // Newest first: what still fits stays.
    Statement s(db_->handle,
                "SELECT id, bytes, committed_unix_ms, sealed_at_server AND committed >= chunks"
                " FROM attempts ORDER BY sealed_at_server AND committed >= chunks,"
                " committed_unix_ms DESC, id DESC");
    uint64_t kept = 0;
    int rc = 0;
    while ((rc = s.Step()) == SQLITE_ROW) {
      kept += static_cast<uint64_t>(s.IntAt(1));
      if (s.IntAt(3) == 0) continue;  // the server does not have it
      bool old = s.IntAt(2) <= old_ms;
      if (old || (retention.bytes > 0 && kept > retention.bytes))
        going.push_back({s.BlobAt(0), !old});
    }
    if (rc != SQLITE_DONE) return db_->Fail("looking for what may go");
  }
  Pruned out;
  for (const auto& [id, early] : going) {
    Statement s(db_->handle, "DELETE FROM attempts WHERE id = ?");
    if (s.Blob(id).Step() != SQLITE_DONE) return db_->Fail("pruning");
    ++out.attempts;
    if (early) ++out.early;
  }
  return out;
}

RecordingLock::~RecordingLock() {
  if (file_ >= 0) ::close(file_);
}

Result<RecordingLock> Spool::LockForRecording() {
  fs::path path = db_->file.parent_path() / "recording.lock";
  int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) {
    return Status(Code::kStorage, "cannot open " + path.string() + " (" + std::strerror(errno) +
                                      "): " + WhatToDo(SQLITE_CANTOPEN));
  }
  RecordingLock lock(file);
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return lock;
  return Status(Code::kConflict, "another enamel-station is recording into " +
                                     path.parent_path().string() +
                                     ": end that one first, or use a folder of its own (--data)");
}

}  // namespace enamel::station
