#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "server/s3/s3_client.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// An S3 store that several servers share (s3_blobs.h).
struct S3Place {
  s3::S3Options store{};
  std::string prefix{};  // of every key; what else is in the bucket is left alone
};

struct StoreOptions {
  // Created if absent, mode 0700. An empty folder or a data folder that lets others in gets that
  // mode; one with anything else in it is refused (kForbidden).
  std::filesystem::path folder;
  // The server holds the folder's lock (LOCK, flock) as long as it runs. The command line opens the
  // same folder beside it without: SQLite's own locks are enough for that, except to migrate.
  bool hold_lock = false;
  int readers = 4;  // read connections, opened as needed
  // Asked before every statement that writes, every COMMIT and every blob; true makes that one
  // fail. For tests (fail the Nth operation). Empty: never.
  std::function<bool()> fail_next{};
  // With less free space no recording is taken (StoreHealth); signing in, reading and erasing still
  // work. 0: no limit.
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
  // Runs each change, rolls it back and runs it again, as a server's database may require. For
  // tests.
  bool change_twice = false;
  // How much of a sealed recording is one blob (recordings/trace_parts.h); less for tests.
  size_t trace_part_bytes = size_t{4} << 20;
  // Where blobs are instead of in FOLDER/blobs. With rows in enamel.db for tests alone: two servers
  // with a database each would delete each other's blobs (ReadDatabaseFile refuses it).
  std::optional<S3Place> s3_blobs{};
  // Where keys are instead of in FOLDER/keyring, and the file of the key that they are wrapped
  // with.
  struct KeyBucket {
    S3Place place;
    std::filesystem::path master_key;
  };
  std::optional<KeyBucket> s3_keys{};
};

inline Disk& DiskOf(const StoreOptions& options) {
  return options.disk != nullptr ? *options.disk : SystemDisk();
}

}  // namespace enamel::server
