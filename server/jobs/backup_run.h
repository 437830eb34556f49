#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/storage/audit/actor.h"
#include "server/storage/store.h"
#include "server/training/types.h"

namespace enamel::server {

// What the audit trail calls a backup that was finished, begun by the page, or not finished. The
// object is the backup's folder.
inline constexpr char kBackupMade[] = "store.backup";
inline constexpr char kBackupStarted[] = "store.backup_start";
inline constexpr char kBackupFailed[] = "store.backup_failed";  // after: {"problem"}

// The folder in which a backup that begins now goes, by its second: 2026-09-01T030000 (UTC); as
// NewBackupIn (storage/backup/backup.h).
std::string BackupName();
inline constexpr char kRestored[] = "store.restore";  // by `enamel-server restore`
// A restore drill that began, one that was passed, one that failed. The object is the backup's
// folder, or empty.
inline constexpr char kDrillStarted[] = "store.drill_start";
inline constexpr char kDrillPassed[] = "store.drill";
inline constexpr char kDrillFailed[] = "store.drill_failed";  // after: {"problem"}

// Makes backups of the running server's school, one at a time: starts `enamel-server backup
// --report` (server/commands/upkeep.h), follows it and notes its end in the audit trail. In a
// process of its own, because only a process can be ended while a disk or a store hangs. Its locks
// end with it, and it leaves a .part.
//
// Every week it also tries whether the newest backup can be restored: `enamel-server restore
// --report` into a folder of the data folder, as slowly as others leave room for, and removes that
// again. The trail has the result.
//
// Thread safety: Into before anything else; then any thread. The destructor ends a running backup
// and does not wait for its process.
class BackupRun {
 public:
  struct Place {
    std::filesystem::path folder;   // must exist; empty: no backup can be made
    std::filesystem::path within;   // in it, a folder for each backup; empty: in it itself
    std::filesystem::path keyring;  // as `backup --keyring`; empty: the keys go into the backup
    std::filesystem::path program;  // empty: enamel-server beside the running program
    // A process that says nothing for so long hangs. The longest honest silence is a sync of what
    // the kernel holds back, some 20 GB at 100 MB/s.
    std::chrono::milliseconds silence = std::chrono::minutes(10);
    // Else tomorrow night's meets it.
    std::chrono::milliseconds most = std::chrono::hours(20);
    // Restore drills: how often one is due, how soon after one that failed, and when this is looked
    // at. Every process that serves the school looks; the trail says what the others did.
    std::chrono::milliseconds drill = std::chrono::days(7);
    std::chrono::milliseconds drill_again = std::chrono::days(1);
    std::chrono::milliseconds look = std::chrono::minutes(10);
    std::chrono::milliseconds drill_most = std::chrono::hours(6);
  };
  struct Running {
    UnixMs since_ms = 0;
    bool here = true;     // false: another server of the school makes it
    std::string phase{};  // "database", "blobs", "keys"; empty: not known yet
    uint64_t done = 0, all = 0;
  };
  struct Failure {
    UnixMs at_ms = 0;
    std::string problem;
  };
  // Of a restore drill.
  struct Drill {
    UnixMs at_ms = 0;
    std::string place;    // the backup
    std::string problem;  // empty: everything was restored and agrees
  };
  struct State {
    std::filesystem::path folder;
    std::optional<Running> running;
    std::optional<Failure> failed;  // the last one, unless one was finished since
    std::optional<Drill> drill;     // the last one
  };

  explicit BackupRun(Store& store) : store_(store) {}
  BackupRun(const BackupRun&) = delete;
  BackupRun& operator=(const BackupRun&) = delete;

  // With a folder, restore drills begin.
  void Into(Place place);
  // Errors: kConflict (one is running, also by the command line or another server; data is being
  // removed; there is no folder), the store's.
  Status Start(const Actor& by);
  // Errors: the store's.
  Result<State> Look() const;
  // Of the trail. None: there was none. Errors: the store's.
  static Result<std::optional<Drill>> LastDrill(AuditRows& audit);

 private:
  struct Made {
    uint64_t files = 0, bytes = 0, missing = 0;
  };
  Status MustBeFree() const;
  void Work(const std::filesystem::path& target, const Actor& by, const std::stop_token& stop);
  Status NoteFailure(const Actor& by, const std::filesystem::path& target, const Status& problem);
  Result<Made> Make(const std::filesystem::path& target, const std::stop_token& stop);
  void Drills(const std::stop_token& stop);
  Result<bool> DrillIsDue() const;
  void DrillOnce(const std::stop_token& stop);
  Status TryRestore(const std::filesystem::path& backup, const std::stop_token& stop);
  std::optional<Running> running() const;

  Store& store_;
  Place place_;
  mutable Mutex mutex_;
  std::optional<Running> running_ ENAMEL_GUARDED_BY(mutex_);
  std::jthread thread_ ENAMEL_GUARDED_BY(mutex_);  // last: ends first
  std::jthread drills_;
};

}  // namespace enamel::server
