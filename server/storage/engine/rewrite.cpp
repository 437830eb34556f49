#include "server/storage/engine/rewrite.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string>

#include "common/base/file.h"

namespace enamel::server::sqlite {

Result<Rewriter::Upkeep> Rewriter::TakeUpkeep() {
  ENAMEL_ASSIGN_OR_RETURN(auto lock, TakeUpkeepLock(folder_, FolderLock::Mode::kExclusive));
  return Upkeep(std::move(lock), upkeep_);
}

Status Rewriter::Mark() { return WriteFileDurably(folder_ / kRewriteMark, {}); }

bool Rewriter::marked() const {
  std::error_code error;
  return std::filesystem::exists(folder_ / kRewriteMark, error);
}

// The lock is asked last: it opens a file, and this runs between two looks at a busy database.
bool Rewriter::OthersErase() const { return upkeep_ == 0 && marked() && IsUpkeepAlone(folder_); }

Status Rewriter::RunIfMarked(Writer& writer) {
  if (!marked()) return Status::Ok();
  spdlog::info("the database is being written anew after an erasure; changes wait until it is");
  const auto begin = std::chrono::steady_clock::now();
  running_ = true;
  Status status = writer.RunAlone([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const uint64_t bytes, db.RewriteBytes());
    ENAMEL_RETURN_IF_ERROR(space_.RoomFor(bytes));
    return db.Rewrite();
  });
  running_ = false;
  std::error_code error;
  if (status.ok() && !std::filesystem::remove(folder_ / kRewriteMark, error) && error) {
    status = Status(Code::kStorage,
                    "cannot remove " + (folder_ / kRewriteMark).string() + ": " + error.message());
  }
  if (status.ok()) {
    std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    spdlog::info("the database is written anew, which took {:.1f} s", took.count());
  } else {
    spdlog::warn(
        "the database could not be written anew after an erasure: {}. Copies of what was erased "
        "may stay in unused parts of it until the server does that, tried again every hour and "
        "after its next start",
        status.message());
  }
  return status;
}

}  // namespace enamel::server::sqlite
