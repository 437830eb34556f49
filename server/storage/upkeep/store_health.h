#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "common/base/histogram.h"
#include "common/base/result.h"
#include "common/sql/db.h"
#include "server/s3/s3_figures.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/database_look.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/folder/space_guard.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/ingest_counters.h"

namespace enamel::server {

// How the store does. Counters are since it was opened.
struct StoreHealth {
  bool takes_recordings = true;
  std::string problem;  // why not, and what to do; names no path
  std::string waiting;  // why changes take longer than usual at the moment; empty: they do not
  // What other servers may have too: the problem is the database's; the store of blobs or of keys
  // cannot be used.
  bool database_fails = false, blobs_fail = false, keys_fail = false;
  bool writes_fail = false;  // the last change could not be written
  uint64_t free_bytes = 0, min_free_bytes = 0, database_bytes = 0, log_bytes = 0;
  uint64_t commits = 0, writes = 0, failed_commits = 0;
  Histogram::Counts commits_took;
  size_t queued = 0;         // changes that wait to be written
  double oldest_wait_s = 0;  // of the oldest of them
  // Of the newest commits, at most 1000: 99 of 100 took at most so long; 0: none is timed.
  size_t timed_commits = 0;
  double commit_p99_s = 0;
  uint64_t chunks = 0, chunk_bytes = 0, sealed = 0;
  // How far this machine's clock is ahead of the database's; 0 where they are one.
  int64_t clock_ahead_ms = 0;
  std::string clock_problem;  // which clock is too far off, and what to do; empty: none is
  bool clock_is_off = false;  // this machine's is, most others agree
  sql::Standby standby = sql::Standby::kNotKept;
  std::optional<s3::S3Figures> blob_store, key_store;  // none: they are files
};

// Says how the store does. Thread safety: any thread.
class StoreHealthCheck {
 public:
  // A change that waits longer shows that the database is stuck.
  static constexpr std::chrono::seconds kLongestWait{4};

  // The parts it checks.
  struct Parts {
    std::filesystem::path folder;
    SpaceGuard& space;
    Transactions& rows;
    const Rewriter& rewriter;
    const DatabaseLook& look;
    RecordingGate& gate;
    Blobs& blobs;
    Keyring& keyring;
    const IngestCounters& counters;
  };
  explicit StoreHealthCheck(Parts parts) : parts_(std::move(parts)) {}

  // Never fails: it reports trouble.
  StoreHealth Health();
  // After a write that failed: writes something small, so that Health knows whether writing works
  // again. Else nothing.
  Status TryWrite();

 private:
  void AddSizes(StoreHealth& out);
  void AddCommits(StoreHealth& out);
  void AddClock(StoreHealth& out);
  // `database`: it is the database's.
  std::string Problem(bool& database);
  // Why changes take long, or some things cannot be done; empty: neither.
  std::string Waiting();

  const Parts parts_;
};

}  // namespace enamel::server
