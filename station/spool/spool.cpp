#include "station/spool/spool.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "common/base/unix_time.h"
#include "spool_schema.h"
#include "station/spool/statement.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr int kSchemaVersion = 4;
constexpr int kBusy_ms = 10'000, kWalRetry_ms = 10;

std::string WhatToDo(int code) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return "the disk is full: free space there";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return "make the folder writable for this user, or choose another with --data";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "the file is damaged: 'enamel-station spool verify' says which recordings are hit, "
             "'enamel-station spool salvage --out FOLDER' saves what can be read of it";
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
  fs::path copy;  // folder that it is read in; empty: where it lies

  ~Db() {
    sqlite3_close(handle);
    std::error_code error;
    if (!copy.empty()) fs::remove_all(copy, error);
  }

  Status Fail(const char* doing) const {
    int code = sqlite3_extended_errcode(handle);
    bool damaged = (code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB;
    return Status(Code::kStorage,
                  "spool " + file.string() + ": " + doing + " failed (" + sqlite3_errmsg(handle) +
                      "); " + WhatToDo(code),
                  damaged ? kDamagedSpool : "");
  }
  Status Exec(const char* sql, const char* doing) {
    return sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) == SQLITE_OK ? Status::Ok()
                                                                             : Fail(doing);
  }
  Status UseWal();
  Result<int64_t> Version();
  Status CheckVersion(int64_t version) const;
  Status CheckNotLost() const;
  Status Create();
  Status OpenToRead(const std::string& uri, int flags);
  Status OpenCopy();
  // Creates the tables, or migrates them; nothing when another process has done it meanwhile.
  Status BringUpToDate();
};

namespace {

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
    "resumed, refused_unix_ms, waits_because, waits_since_unix_ms, tried_unix_ms"
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
  out.refused_unix_ms = row.IntAt(16);
  out.waits_because = row.TextAt(17);
  out.waits_since_unix_ms = row.IntAt(18);
  out.tried_unix_ms = row.IntAt(19);
  return out;
}

Status NoAttempt(const Uuid& attempt) {
  return Status(Code::kNotFound, "the spool has no attempt " + attempt.Text() +
                                     ": 'enamel-station spool list' shows those it has");
}

Status Differs(const char* what, uint64_t counted, uint64_t found) {
  return Status(Code::kConflict, std::string(what) + ": the spool counts " +
                                     std::to_string(counted) + ", there are " +
                                     std::to_string(found));
}

// Chain, signatures and seal of a recording, and what the spool counts of it.
Status VerifyRecording(const SpooledAttempt& attempt, ByteView header,
                       const std::vector<SpooledChunk>& chunks,
                       const std::optional<trace::PublicKey>& key) {
  ENAMEL_ASSIGN_OR_RETURN(auto decoded, trace::DecodeHeader(header));
  if (decoded.ticket.attempt != attempt.id) {
    return Status(Code::kConflict,
                  "its header is that of attempt " + decoded.ticket.attempt.Text());
  }
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
  if (chunks.size() != attempt.chunks) return Differs("chunks", attempt.chunks, chunks.size());
  if (ticks != attempt.ticks) return Differs("ticks", attempt.ticks, ticks);
  if (gap_ticks != attempt.gap_ticks) return Differs("gap ticks", attempt.gap_ticks, gap_ticks);
  if (bytes != attempt.bytes) return Differs("bytes", attempt.bytes, bytes);
  if (attempt.committed > attempt.chunks) {
    return Differs("chunks the server has", attempt.committed, attempt.chunks);
  }
  return attempt.seal ? chain.AcceptSeal(*attempt.seal) : Status::Ok();
}

// Which start of the machine this is, and the time since, with sleep: no clock that is set changes
// it. proc(5), random/boot_id.
struct SinceBoot {
  std::string boot;
  int64_t ms = 0;
};
SinceBoot BootNow() {
  SinceBoot out;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> out.boot;
  timespec t{};
  clock_gettime(CLOCK_BOOTTIME, &t);
  out.ms = t.tv_sec * int64_t{1000} + t.tv_nsec / 1'000'000;
  return out;
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
    std::string sql = *version == 0 ? kSpoolSchema : "";
    if (*version == 1) sql += kSpoolFrom1;
    if (*version == 1 || *version == 2) sql += kSpoolFrom2;
    if (*version >= 1 && *version <= 3) sql += kSpoolFrom3;
    sql += "PRAGMA user_version = " + std::to_string(kSchemaVersion);
    done = Exec(sql.c_str(), *version == 0 ? "creating its tables" : "bringing it to version 4");
  }
  if (done.ok()) return Exec("COMMIT", "creating its tables");
  (void)Exec("ROLLBACK", "going back");
  return done;
}

Spool::Spool(std::unique_ptr<Db> db) : db_(std::move(db)) {}
Spool::~Spool() = default;
const fs::path& Spool::file() const { return db_->file; }

// Where the file is to be: what must not be taken for a new spool. Empty, or gone with its log left
// behind: SQLite would begin anew and throw the log away.
Status Spool::Db::CheckNotLost() const {
  std::error_code error;
  const bool there = fs::exists(file, error);
  const fs::path log = file.string() + "-wal";
  const bool log_holds = fs::exists(log, error) && fs::file_size(log, error) > 0;
  if (there ? fs::file_size(file, error) > 0 : !log_holds) return Status::Ok();
  return Status(Code::kStorage,
                "spool " + file.string() + (there ? " is empty (0 bytes)" : " is gone") +
                    (log_holds ? ", its log " + log.string() + " is there" : "") +
                    ": recordings were kept in it. Put a copy of it back, or move what is left of "
                    "it away to begin with an empty spool",
                kLostSpool);
}

// The whole file at once, so that an empty one is never a new one. Nothing when another process was
// first.
Status Spool::Db::Create() {
  const fs::path made = file.string() + ".new-" + std::to_string(::getpid());
  {
    Db fresh;
    fresh.file = made;
    if (sqlite3_open_v2(made.c_str(), &fresh.handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                        nullptr) != SQLITE_OK) {
      return fresh.Fail("creating");
    }
    std::error_code error;
    fs::permissions(made, fs::perms::owner_read | fs::perms::owner_write, error);
    Status done = fresh.UseWal();
    if (done.ok()) done = fresh.BringUpToDate();
    if (!done.ok()) {
      sqlite3_close(std::exchange(fresh.handle, nullptr));
      for (const char* end : {"", "-wal", "-shm"}) fs::remove(made.string() + end, error);
      return done;
    }
  }
  // Some file systems have no links.
  bool linked = ::link(made.c_str(), file.c_str()) == 0 || errno == EEXIST;
  std::error_code error;
  if (linked)
    fs::remove(made, error);
  else
    fs::rename(made, file, error);
  return !error ? Status::Ok()
                : Status(Code::kStorage, "cannot create " + file.string() + " (" + error.message() +
                                             "): " + WhatToDo(SQLITE_CANTOPEN));
}

Status Spool::Db::CheckVersion(int64_t version) const {
  if (version <= kSchemaVersion) return Status::Ok();
  return Status(Code::kVersion, "spool " + file.string() + " is of version " +
                                    std::to_string(version) + ", this program knows " +
                                    std::to_string(kSchemaVersion) +
                                    ": use the newer enamel-station that made it");
}

Result<std::unique_ptr<Spool>> Spool::Open(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Status(Code::kStorage, "cannot create the folder " + folder.string() + " (" +
                                      error.message() + "): choose another with --data");
  }
  auto db = std::make_unique<Db>();
  db->file = folder / kSpoolFile;
  ENAMEL_RETURN_IF_ERROR(db->CheckNotLost());
  if (!fs::exists(db->file, error)) ENAMEL_RETURN_IF_ERROR(db->Create());
  if (sqlite3_open_v2(db->file.c_str(), &db->handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_FULLMUTEX,
                      nullptr) != SQLITE_OK) {
    return db->Fail("opening");
  }
  sqlite3_busy_timeout(db->handle, kBusy_ms);
  // Recordings identify people: nobody but the owner reads them.
  fs::permissions(db->file, fs::perms::owner_read | fs::perms::owner_write, error);
  ENAMEL_RETURN_IF_ERROR(db->UseWal());
  ENAMEL_RETURN_IF_ERROR(
      db->Exec("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON", "opening"));
  ENAMEL_ASSIGN_OR_RETURN(auto version, db->Version());
  ENAMEL_RETURN_IF_ERROR(db->CheckVersion(version));
  if (version < kSchemaVersion) ENAMEL_RETURN_IF_ERROR(db->BringUpToDate());
  if (sqlite3_db_readonly(db->handle, "main") == 1) {
    return Status(Code::kStorage,
                  "spool " + db->file.string() + " is not writable: " + WhatToDo(SQLITE_READONLY));
  }
  return std::unique_ptr<Spool>(new Spool(std::move(db)));
}

// Also a file that is cut short, or whose schema has errors, is opened for what can be read of it.
Status Spool::Db::OpenToRead(const std::string& uri, int flags) {
  sqlite3_close(std::exchange(handle, nullptr));
  if (sqlite3_open_v2(uri.c_str(), &handle, flags | SQLITE_OPEN_URI | SQLITE_OPEN_FULLMUTEX,
                      nullptr) != SQLITE_OK) {
    return Fail("opening");
  }
  sqlite3_busy_timeout(handle, kBusy_ms);
  return Exec("PRAGMA writable_schema = ON; SELECT count(*) FROM sqlite_schema", "opening");
}

// What cannot be read where it lies (its log needs a writable folder, or it is of an older version)
// is read in a copy.
Status Spool::Db::OpenCopy() {
  std::string name = (fs::temp_directory_path() / "enamel_spool_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    return Status(Code::kStorage, "cannot make a folder in " + fs::temp_directory_path().string() +
                                      " to read " + file.string() + " in a copy (" +
                                      std::strerror(errno) + ")");
  }
  copy = name;
  std::error_code error;
  fs::copy_file(file, copy / kSpoolFile, error);
  const std::string log = file.string() + "-wal";
  if (!error && fs::exists(log)) {
    fs::copy_file(log, (copy / kSpoolFile).string() + "-wal", error);
  }
  if (error) {
    return Status(Code::kStorage, "cannot copy " + file.string() + " to " + copy.string() + " (" +
                                      error.message() + ")");
  }
  return OpenToRead((copy / kSpoolFile).string(), SQLITE_OPEN_READWRITE);
}

Result<std::unique_ptr<Spool>> Spool::OpenToRead(const fs::path& folder) {
  auto db = std::make_unique<Db>();
  db->file = folder / kSpoolFile;
  ENAMEL_RETURN_IF_ERROR(db->CheckNotLost());
  std::error_code error;
  if (!fs::exists(db->file, error)) {
    return Status(Code::kNotFound, "there is no spool in " + folder.string() +
                                       ": nothing was recorded there, or another folder is meant "
                                       "(--data)");
  }
  const std::string path = db->file.string();
  Status opened = db->OpenToRead(path, SQLITE_OPEN_READONLY);
  const int code = db->handle == nullptr ? SQLITE_CANTOPEN : sqlite3_errcode(db->handle);
  if (!opened.ok() && (code == SQLITE_CANTOPEN || code == SQLITE_READONLY)) opened = db->OpenCopy();
  ENAMEL_RETURN_IF_ERROR(opened);
  ENAMEL_ASSIGN_OR_RETURN(auto version, db->Version());
  ENAMEL_RETURN_IF_ERROR(db->CheckVersion(version));
  if (version < kSchemaVersion) {
    if (db->copy.empty()) ENAMEL_RETURN_IF_ERROR(db->OpenCopy());
    ENAMEL_RETURN_IF_ERROR(db->BringUpToDate());
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
              "INSERT INTO attempts (id, header, header_sha256, exercise, profile, created_unix_ms,"
              " boot_id, boot_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  const SinceBoot now = BootNow();
  s.Blob(id)
      .Blob(bytes)
      .Blob(hash.view())
      .Text(exercise)
      .Text(profile)
      .Int(UnixMs())
      .Text(now.boot)
      .Int(now.ms);
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("storing an attempt");
}

Status Spool::PutChunk(const Uuid& attempt, ByteView chunk) {
  ENAMEL_ASSIGN_OR_RETURN(auto head, trace::DecodeChunkHead(chunk));
  if (head.head.attempt != attempt) {
    return Status(Code::kConflict, "the chunk belongs to attempt " + head.head.attempt.Text() +
                                       ", not to " + attempt.Text());
  }
  std::lock_guard lock(mutex_);
  {
    Statement s(db_->handle, "SELECT sha256 FROM chunks WHERE attempt = ? AND seq = ?");
    int rc = s.Blob(attempt.view()).Int(head.head.seq).Step();
    if (rc == SQLITE_ROW) {
      if (s.BlobAt(0) == Bytes(head.hash.bytes.begin(), head.hash.bytes.end())) return Status::Ok();
      return Status(Code::kConflict, "attempt " + attempt.Text() + " has another chunk " +
                                         std::to_string(head.head.seq) + " already");
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
        .Int(head.head.seq)
        .Blob(head.hash.view())
        .Blob(chunk)
        .Int(head.head.count)
        .Int(head.head.gap_ticks)
        .Int(UnixMs());
    if (s.Step() != SQLITE_DONE) return db_->Fail("storing a chunk");
  }
  {
    Statement s(
        db_->handle,
        "UPDATE attempts SET chunks = chunks + 1, ticks = ticks + ?, gap_ticks = gap_ticks + ?,"
        " bytes = bytes + ?, boot_id = ?, boot_ms = ? WHERE id = ?");
    const SinceBoot now = BootNow();
    s.Int(head.head.count)
        .Int(head.head.gap_ticks)
        .Int(static_cast<int64_t>(chunk.size()))
        .Text(now.boot)
        .Int(now.ms)
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
  s.Int(next_seq).Int(UnixMs()).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking chunks");
}

Status Spool::MarkCommitted(const Uuid& attempt, uint32_t seq) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET committed = ?1, committed_unix_ms = ?2"
              " WHERE id = ?3 AND committed < ?1");
  s.Int(int64_t{seq} + 1).Int(UnixMs()).Blob(attempt.view());
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
  s.Int(UnixMs());
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking a seal");
}

// What went well changes nothing where there is nothing to forget.
Status Spool::MarkTried(const Uuid& attempt, const std::string& problem) {
  if (!problem.empty()) return MarkTriedWhere("id = ?3", attempt, problem);
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET waits_because = NULL, waits_since_unix_ms = NULL,"
              " tried_unix_ms = NULL WHERE id = ? AND waits_because IS NOT NULL");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("marking an attempt");
}

Status Spool::MarkAllTried(const std::string& problem) {
  return MarkTriedWhere(
      "refused IS NULL AND (committed < chunks OR (seal_chunks IS NOT NULL AND NOT "
      "sealed_at_server)) AND ?3 IS NOT NULL",
      {}, problem);
}

Status Spool::MarkTriedWhere(const char* where, const Uuid& attempt, const std::string& problem) {
  std::lock_guard lock(mutex_);
  const std::string sql =
      "UPDATE attempts SET waits_because = ?1, tried_unix_ms = ?2,"
      " waits_since_unix_ms = coalesce(waits_since_unix_ms, ?2) WHERE " +
      std::string(where);
  Statement s(db_->handle, sql.c_str());
  s.Text(problem).Int(UnixMs()).Blob(attempt.view());
  return s.Step() == SQLITE_DONE ? Status::Ok() : db_->Fail("marking what waits");
}

Status Spool::MarkRefused(const Uuid& attempt, const std::string& why) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET refused = ?, refused_unix_ms = ?, waits_because = NULL,"
              " waits_since_unix_ms = NULL, tried_unix_ms = NULL WHERE id = ?");
  return s.Text(why).Int(UnixMs()).Blob(attempt.view()).Step() == SQLITE_DONE
             ? Status::Ok()
             : db_->Fail("marking an attempt");
}

Status Spool::ClearRefusal(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE attempts SET refused = NULL, refused_unix_ms = NULL WHERE id = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
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
  ENAMEL_ASSIGN_OR_RETURN(auto stored, Get(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, ChunksFrom(attempt, 0, SIZE_MAX >> 1));
  trace::TraceFile file;
  file.header = std::move(header);
  for (SpooledChunk& chunk : chunks) file.chunks.push_back(std::move(chunk.bytes));
  file.seal = stored.seal;
  return file;
}

Status Spool::PutLoopFacts(const Uuid& attempt, const KeptLoopFacts& facts) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "INSERT OR REPLACE INTO loop_facts (attempt, run, ended_unix_ms, facts)"
              " SELECT id, ?2, ?3, ?4 FROM attempts WHERE id = ?1");
  s.Blob(attempt.view()).Int(facts.run).Int(facts.ended_unix_ms).Text(facts.json);
  if (s.Step() != SQLITE_DONE) return db_->Fail("storing how the loop went");
  return sqlite3_changes(db_->handle) == 1 ? Status::Ok() : NoAttempt(attempt);
}

Result<std::vector<KeptLoopFacts>> Spool::LoopFactsOf(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "SELECT run, ended_unix_ms, facts FROM loop_facts WHERE attempt = ? ORDER BY run");
  s.Blob(attempt.view());
  std::vector<KeptLoopFacts> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) {
    out.push_back({static_cast<uint32_t>(s.IntAt(0)), s.IntAt(1), s.TextAt(2)});
  }
  if (rc != SQLITE_DONE) return db_->Fail("reading how loops went");
  return out;
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

Result<std::optional<int>> Spool::CountPinTry(const Uuid& attempt, int64_t now_unix_ms,
                                              int free_tries, int most, int64_t first_wait_ms) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "UPDATE tickets SET wrong_pins = wrong_pins + 1, wait_unix_ms = CASE"
              " WHEN wrong_pins < ?1 THEN 0 ELSE ?2 + (?3 << (wrong_pins - ?1)) END"
              " WHERE wait_unix_ms <= ?2 AND wrong_pins < ?4 AND attempt = ?5"
              " RETURNING wrong_pins");
  s.Int(free_tries).Int(now_unix_ms).Int(first_wait_ms).Int(most).Blob(attempt.view());
  int rc = s.Step();
  if (rc == SQLITE_DONE) return std::optional<int>();
  if (rc != SQLITE_ROW) return db_->Fail("counting a try of a PIN");
  int tries = static_cast<int>(s.IntAt(0));
  return s.Step() == SQLITE_DONE ? Result<std::optional<int>>(tries)
                                 : db_->Fail("counting a try of a PIN");
}

Status Spool::ForgetPinTries(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "UPDATE tickets SET wrong_pins = 0, wait_unix_ms = 0 WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("forgetting tries of a PIN");
}

Status Spool::RemoveTicket(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle, "DELETE FROM tickets WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : db_->Fail("removing a ticket");
}

Status Spool::VerifyPages() {
  std::lock_guard lock(mutex_);
  {
    Statement s(db_->handle, "PRAGMA integrity_check(1)");
    if (s.Step() != SQLITE_ROW) return db_->Fail("checking its pages");
    if (std::string found = s.TextAt(0); found != "ok") {
      return Status(Code::kStorage,
                    "spool " + db_->file.string() + ": " + found + "; " + WhatToDo(SQLITE_CORRUPT));
    }
  }
  Statement s(db_->handle,
              "SELECT count(*) FROM chunks WHERE attempt NOT IN (SELECT id FROM attempts)");
  if (s.Step() != SQLITE_ROW) return db_->Fail("checking its chunks");
  if (s.IntAt(0) == 0) return Status::Ok();
  return Status(Code::kStorage, "spool " + db_->file.string() + ": " + std::to_string(s.IntAt(0)) +
                                    " chunks are of attempts that are not there");
}

Status Spool::VerifyAttempt(const SpooledAttempt& attempt,
                            const std::optional<trace::PublicKey>& key) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(attempt.id));
  {
    std::lock_guard lock(mutex_);
    Statement s(db_->handle, "SELECT header_sha256 FROM attempts WHERE id = ?");
    if (s.Blob(attempt.id.view()).Step() != SQLITE_ROW) return db_->Fail("reading a header's hash");
    const Sha256 hash = HashSha256(header);
    if (s.BlobAt(0) != Bytes(hash.bytes.begin(), hash.bytes.end())) {
      return Status(Code::kConflict, "its header is not the one whose hash is kept beside it");
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, ChunksFrom(attempt.id, 0, SIZE_MAX >> 1));
  return VerifyRecording(attempt, header, chunks, key);
}

Result<std::vector<SpoolVerdict>> Spool::Verify(const std::optional<trace::PublicKey>& key,
                                                Status* pages) {
  Status found = VerifyPages();
  if (pages != nullptr)
    *pages = found;
  else
    ENAMEL_RETURN_IF_ERROR(found);
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, List());
  std::vector<SpoolVerdict> out;
  for (SpooledAttempt& attempt : attempts) {
    Status status = VerifyAttempt(attempt, key);
    out.push_back({std::move(attempt), std::move(status)});
  }
  return out;
}

Result<Silence> Spool::SilenceOf(const Uuid& attempt) {
  std::lock_guard lock(mutex_);
  Statement s(db_->handle,
              "SELECT coalesce((SELECT spooled_unix_ms FROM chunks WHERE attempt = ?1"
              " ORDER BY seq DESC LIMIT 1), created_unix_ms), boot_id, boot_ms"
              " FROM attempts WHERE id = ?1");
  int rc = s.Blob(attempt.view()).Step();
  if (rc == SQLITE_DONE) return NoAttempt(attempt);
  if (rc != SQLITE_ROW) return db_->Fail("reading when an attempt was recorded last");
  constexpr int64_t kStepped_ms = 1000;
  const SinceBoot now = BootNow();
  const int64_t by_clock_ms = UnixMs() - s.IntAt(0);
  Silence out{std::max<int64_t>(by_clock_ms, 0), by_clock_ms < -kStepped_ms};
  if (!s.IsNull(1) && s.TextAt(1) == now.boot) {
    const int64_t by_boot_ms = now.ms - s.IntAt(2);
    out.clock_stepped |= by_boot_ms - by_clock_ms > kStepped_ms;
    out.ms = std::max(out.ms, by_boot_ms);
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

std::string PrunedText(const Pruned& pruned, const Retention& retention) {
  if (pruned.early == 0) return {};
  return std::to_string(pruned.early) +
         " recordings that the server has were forgotten here before their time, as the spool may "
         "take " +
         std::to_string(retention.bytes / 1'000'000) +
         " MB only: a server restored from an older backup cannot get them back from here";
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

Status Spool::ProveWritable(uint64_t room_bytes) {
  const fs::path folder = db_->file.parent_path();
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
  std::lock_guard lock(mutex_);
  // Writes its first page although the value is the same.
  const std::string sql = "PRAGMA user_version = " + std::to_string(kSchemaVersion);
  return db_->Exec(sql.c_str(), "a test write");
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
