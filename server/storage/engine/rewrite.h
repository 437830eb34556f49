#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/engine/lease.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/space_guard.h"

namespace enamel::server {

// In the data folder while an erasure may have left copies in the database; the row of rewrite_due
// says the same to several servers.
inline constexpr char kRewriteMark[] = "REWRITE";

// Rewrites the database after an erasure. SQLite overwrites a deleted row, but not the copies that
// moving rows has left in free pages and gaps; PostgreSQL overwrites nothing. A mark records that a
// rewrite is due, even after a crash: a file in the data folder, or a row if several servers share
// the database, so that any of them does it. Thread safety: any thread.
class Rewriter {
 public:
  Rewriter(std::filesystem::path folder, SpaceGuard& space, Transactions& rows)
      : folder_(std::move(folder)), space_(space), rows_(rows) {}

  // The folder's UPKEEP lock, alone, and the lease of that name, until destroyed.
  class Upkeep {
   public:
    Upkeep(FolderLock lock, std::unique_ptr<Lease> lease, std::atomic<int>& count)
        : lock_(std::move(lock)), lease_(std::move(lease)), count_(&count) {
      ++count;
    }
    ~Upkeep() {
      if (count_ != nullptr) --*count_;
    }
    Upkeep(Upkeep&& other) noexcept
        : lock_(std::move(other.lock_)),
          lease_(std::move(other.lease_)),
          count_(std::exchange(other.count_, nullptr)) {}
    Upkeep& operator=(Upkeep&&) = delete;

   private:
    FolderLock lock_;
    std::unique_ptr<Lease> lease_;
    std::atomic<int>* count_;
  };
  // Errors: kUnavailable (somebody makes a backup, or has it alone; field kLeaseHeld: on another
  // server).
  Result<Upkeep> TakeUpkeep();
  // Somebody has it, on any server of the school, or makes a backup of the folder: kUnavailable,
  // with who.
  Status UpkeepIsFree();

  Status Mark();
  Result<bool> IsMarked() const;
  // If the mark exists, rewrites the database without its freed content, empties the log and
  // removes the mark. Writers wait meanwhile: this store's in the writer's queue, other processes'
  // because of OthersErase. After a failure, which the log has, the mark stays. Requires: Upkeep is
  // held.
  Status RunIfMarked();
  bool running() const { return running_; }
  // Another process finishes an erasure: its write is worth waiting for.
  bool OthersErase() const;

 private:
  bool HasMarkFile() const;
  // Zero where the mark is a file.
  Result<std::optional<Uuid>> FindMark() const;
  Status RemoveMark(const Uuid& mark);

  const std::filesystem::path folder_;
  SpaceGuard& space_;
  Transactions& rows_;
  std::atomic<int> upkeep_{0};  // Upkeep is held so often
  std::atomic<bool> running_{false};
};

}  // namespace enamel::server
