#pragma once

#include <atomic>
#include <filesystem>
#include <utility>

#include "common/base/result.h"
#include "server/storage/engine/folder_lock.h"
#include "server/storage/engine/space_guard.h"
#include "server/storage/engine/writer.h"

namespace enamel::server::sqlite {

// In the data folder while an erasure may have left copies in the database.
inline constexpr char kRewriteMark[] = "REWRITE";

// Writes the database anew after an erasure: SQLite overwrites what is deleted, but not the copies
// that moving rows about has left in free pages and gaps. The mark on the disk says that this is
// still to be done, also after a crash.
// Thread safety: any thread.
class Rewriter {
 public:
  Rewriter(std::filesystem::path folder, SpaceGuard& space)
      : folder_(std::move(folder)), space_(space) {}

  // The folder's UPKEEP lock, alone, until destroyed.
  class Upkeep {
   public:
    Upkeep(FolderLock lock, std::atomic<int>& count) : lock_(std::move(lock)), count_(&count) {
      ++count;
    }
    ~Upkeep() {
      if (count_ != nullptr) --*count_;
    }
    Upkeep(Upkeep&& other) noexcept
        : lock_(std::move(other.lock_)), count_(std::exchange(other.count_, nullptr)) {}
    Upkeep& operator=(Upkeep&&) = delete;

   private:
    FolderLock lock_;
    std::atomic<int>* count_;
  };
  // Errors: kUnavailable (somebody makes a backup, or has it alone).
  Result<Upkeep> TakeUpkeep();

  Status Mark();
  bool marked() const;
  // Where the mark is, writes the database anew without what was freed in it, empties the log and
  // removes the mark. Writers wait meanwhile: this store's in the writer's queue, other processes'
  // because of OthersErase. What fails is in the log; the mark stays then. Requires: Upkeep is held.
  Status RunIfMarked(Writer& writer);
  bool running() const { return running_; }
  // Another process finishes an erasure: its write is worth waiting for.
  bool OthersErase() const;

 private:
  const std::filesystem::path folder_;
  SpaceGuard& space_;
  std::atomic<int> upkeep_{0};  // Upkeep is held so often
  std::atomic<bool> running_{false};
};

}  // namespace enamel::server::sqlite
