#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/s3/s3_client.h"
#include "server/storage/engine/disk.h"
#include "server/storage/store.h"

namespace enamel::server {

// An S3 store that several servers share (s3_blobs.h).
struct S3Place {
  s3::S3Options store{};
  std::string prefix{};  // of every key; what else is in the bucket is left alone
};

struct SqliteOptions {
  // Made when absent, mode 0700. One that is there and lets others in is put right when it is empty
  // or a data folder already, and refused when it holds other things (kForbidden).
  std::filesystem::path folder;
  // The server holds the folder's lock (LOCK, flock) as long as it runs. The command line opens the
  // same folder beside it without: SQLite's own locks are enough for that, except to migrate.
  bool hold_lock = false;
  int readers = 4;  // read connections, opened as needed
  // Asked before every statement that writes, every COMMIT and every blob; true makes that one
  // fail. For tests (fail the Nth operation). Empty: never.
  std::function<bool()> fail_next{};
  // Below this no recording is taken (StoreHealth); signing in, reading, erasing go on. 0: no
  // limit.
  uint64_t min_free_bytes = 0;
  std::chrono::milliseconds free_space_check{1000};  // how often the disk is asked
  bool restoring = false;  // opened by Restore (backup.h), under its own mark
  // Where files go: SQLite's name of a registered VFS (empty: its own) and what else is on the disk
  // (null: the machine's). For tests.
  std::string vfs{};
  Disk* disk = nullptr;
  // How long a write waits for another process's before it is refused. The time in which that
  // process finishes an erasure does not count.
  std::chrono::milliseconds busy_wait{10'000};
  // Every change is made, taken back and made again, as a server's database may ask for. For tests.
  bool change_twice = false;
  // Where blobs are instead of in FOLDER/blobs. With rows in enamel.db for tests alone: two servers
  // with a database each would delete each other's blobs (ReadDatabaseFile refuses it).
  std::optional<S3Place> s3_blobs{};
  // Where keys are instead of in FOLDER/keyring, and the file of the key that they are wrapped with.
  struct KeyBucket {
    S3Place place;
    std::filesystem::path master_key;
  };
  std::optional<KeyBucket> s3_keys{};
};

// The embedded store: DIR/enamel.db (SQLite, WAL, synchronous=FULL), DIR/blobs/xx/<sha256> and
// DIR/keyring (keyring.h), under whose keys everything is kept that shows a person's motion.
// DIR/ticket.key, made when absent, signs every row of the audit trail (schemas/audit.md).
//
// Writes from all threads queue up; the first becomes the leader, runs everything queued in one
// transaction (each write in a savepoint of its own) and one fsync, and hands out the results.
// Chunks of an unsealed attempt are rows; SealAttempt moves them into one write-once blob.
//
// Errors: kStorage (folder not writable, disk full, database damaged), kUnavailable (another server
// holds the folder), kVersion (database made by a newer enamel-server), kInvalidInput (ticket.key is
// no key).
Result<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options);

struct PostgresOptions {
  // libpq's: "postgresql://user@host1,host2/name" or "host=… user=… dbname=…". Several hosts: the one
  // that takes writes is found.
  std::string server;
  // PostgreSQL's name of the place for the tables; made where it is not there. Empty: the user's own.
  std::string schema{};
  // Blobs, key ring and keys; what is SQLite's of these options does not count here.
  SqliteOptions folder{};
};

// The same store with its rows in PostgreSQL 15 (schemas/sql/pg) instead of enamel.db. Errors also:
// kUnavailable (the server, or the library for it, is not there).
Result<std::unique_ptr<Store>> OpenPostgresStore(const PostgresOptions& options);
// Whether a server has its rows there already. Nothing is made. Errors: those of OpenPostgresStore.
Result<bool> HasServers(const PostgresOptions& options);

// The store of a data folder: its rows are in PostgreSQL, its blobs and keys in S3 stores, where the
// folder's database.json says so (engine/database_file.h), else in enamel.db, blobs/ and keyring/. The
// store of blobs is not asked yet. That of keys is, with `hold_lock`: whether it forgets what is deleted,
// and who was erased. Either may be away while a server starts.
Result<std::unique_ptr<Store>> OpenStore(const SqliteOptions& options);

// Newest schema this program knows, 1-based; migrations are schemas/sql/NNNN_*.sql, forward only.
int LatestSchemaVersion();

}  // namespace enamel::server
