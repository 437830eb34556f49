#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/folder/disk.h"

struct sqlite3_vfs;

namespace enamel::server::testing {

// A disk that remembers every operation on a folder, so that a test can ask for its content if the
// power had failed after any one of them. It can also be full.
//
// The files are real. SQLite reaches them through a VFS of its own (vfs()), the store's other files
// use the Disk interface. Durability follows POSIX taken strictly: content when its file was
// synced, a name when its folder was synced after it was made, renamed or removed. Source of when
// SQLite syncs folders: sqlite.org/src, os_unix.c (a new journal's or log's first sync also syncs
// its folder; a new database file's does not).
//
// Thread safety: any thread, as far as SQLite's own rules allow.
class SimulatedDisk final : public Disk {
 public:
  explicit SimulatedDisk(std::filesystem::path folder);
  ~SimulatedDisk() override;
  SimulatedDisk(const SimulatedDisk&) = delete;
  SimulatedDisk& operator=(const SimulatedDisk&) = delete;

  const std::string& vfs() const { return name_; }
  // So far. A power cut "after n" loses everything from operation n on.
  size_t operations() const;

  // What becomes of writes and names that were not synced: all lost, or each kept or lost by the
  // throw of a coin, writes in pieces of 512 bytes.
  enum class Unsynced { kLost, kTorn };
  // Fills `target`, which must be empty, with the disk's content after a power cut.
  void CutAfter(size_t operations, Unsynced unsynced, uint32_t seed,
                const std::filesystem::path& target) const;

  // From now on files' syncs are acknowledged and not done, as bad drives do.
  void SetLying() { lying_ = true; }

  // Asked before SQLite writes to a file (its path below the folder), on the thread that writes,
  // which may be kept waiting. Set while no store is open.
  void SetBeforeWrite(std::function<void(const std::string& path)> ask) {
    before_write_ = std::move(ask);
  }

  // Bytes that can still be written; none: plenty.
  void SetFree(std::optional<uint64_t> bytes);

  Status Replace(const std::filesystem::path& path, ByteView data) override;
  Status MakeFolder(const std::filesystem::path& path) override;
  Status SyncFolder(const std::filesystem::path& path) override;
  Status Remove(const std::filesystem::path& path) override;
  Status Shred(const std::filesystem::path& path) override;
  Result<Content> Hash(const std::filesystem::path& path) override;
  Result<Copied> Copy(const std::filesystem::path& from, const std::filesystem::path& to,
                      bool link) override;
  Status SyncAll(const std::filesystem::path& folder) override;
  Result<uint64_t> FreeBytes(const std::filesystem::path& folder) override;

 private:
  friend struct SimulatedVfs;
  enum class Kind { kCreate, kPut, kWrite, kTruncate, kSync, kDelete, kMakeFolder, kSyncFolder };
  struct Operation {
    Kind kind;
    std::string path;  // relative to the folder; of a folder for the last two
    int64_t at = 0;    // where a write begins; the new size
    Bytes bytes;
  };
  class Replay;

  std::string Relative(const std::filesystem::path& path) const;
  void Record(Kind kind, const std::string& path, int64_t at = 0, ByteView bytes = {});
  // False when there is no room for so many bytes more; negative: gives room back.
  bool Take(int64_t bytes);

  const std::filesystem::path folder_;
  std::string name_;
  std::atomic<bool> lying_{false};
  std::function<void(const std::string&)> before_write_;
  std::unique_ptr<sqlite3_vfs> vfs_;
  mutable std::mutex mutex_;
  std::vector<Operation> log_;    // guarded by mutex_
  std::optional<uint64_t> free_;  // guarded by mutex_
};

}  // namespace enamel::server::testing
