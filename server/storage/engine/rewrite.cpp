#include "server/storage/engine/rewrite.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string>

#include "common/base/file.h"
#include "server/storage/engine/query.h"

namespace enamel::server {

Result<Rewriter::Upkeep> Rewriter::TakeUpkeep() {
  ENAMEL_ASSIGN_OR_RETURN(auto lock, TakeUpkeepLock(folder_, FolderLock::Mode::kExclusive));
  std::unique_ptr<Lease> lease;
  if (rows_.shared()) {
    ENAMEL_ASSIGN_OR_RETURN(auto db, rows_.OpenWriter());
    ENAMEL_ASSIGN_OR_RETURN(lease, Lease::Take(std::move(db), "upkeep"));
  }
  return Upkeep(std::move(lock), std::move(lease), upkeep_);
}

Status Rewriter::UpkeepIsFree() {
  // Shared first: its refusal says that data is being removed, the other one that a backup runs.
  for (const auto mode : {FolderLock::Mode::kShared, FolderLock::Mode::kExclusive}) {
    ENAMEL_RETURN_IF_ERROR(TakeUpkeepLock(folder_, mode).status());
  }
  if (!rows_.shared()) return Status::Ok();
  return rows_.Read([](sql::Db& db) -> Status {
    Query q(db, "SELECT 1 FROM leases WHERE tenant = ?1 AND name = ?2 AND until_ms >= ?3");
    q.Bind("upkeep", NowMs());
    if (q.Next()) return LeaseIsHeld();
    return q.status();
  });
}

Status Rewriter::Mark() {
  if (!rows_.shared()) return WriteFileDurably(folder_ / kRewriteMark, {});
  return rows_.Write([mark = Uuid::New()](sql::Db& db) {
    return Insert(db, "rewrite_due", "since_ms", NowMs(), "mark", mark,
                  " ON CONFLICT (tenant) DO UPDATE SET mark = excluded.mark");
  });
}

bool Rewriter::HasMarkFile() const {
  std::error_code error;
  return std::filesystem::exists(folder_ / kRewriteMark, error);
}

Result<bool> Rewriter::IsMarked() const {
  ENAMEL_ASSIGN_OR_RETURN(const auto mark, FindMark());
  return mark.has_value();
}

Result<std::optional<Uuid>> Rewriter::FindMark() const {
  std::optional<Uuid> mark;
  if (rows_.shared()) {
    ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
      Query q(db, "SELECT mark FROM rewrite_due WHERE tenant = ?1");
      mark.reset();
      if (q.Next()) mark = q.Id(0);
      return q.status();
    }));
  }
  if (!mark && HasMarkFile()) mark = Uuid{};
  return mark;
}

Status Rewriter::RemoveMark(const Uuid& mark) {
  // A mark set during the rewrite stays.
  if (rows_.shared()) {
    ENAMEL_RETURN_IF_ERROR(rows_.Write([&](sql::Db& db) {
      return Query(db, "DELETE FROM rewrite_due WHERE tenant = ?1 AND mark = ?2").Bind(mark).Run();
    }));
  }
  std::error_code error;
  if (std::filesystem::remove(folder_ / kRewriteMark, error) || !error) return Status::Ok();
  return Status(Code::kStorage,
                "cannot remove " + (folder_ / kRewriteMark).string() + ": " + error.message());
}

// The lock last: checking it opens a file, and this runs between two looks at a busy database.
bool Rewriter::OthersErase() const {
  return upkeep_ == 0 && HasMarkFile() && IsUpkeepAlone(folder_);
}

Status Rewriter::RunIfMarked() {
  ENAMEL_ASSIGN_OR_RETURN(const auto mark, FindMark());
  if (!mark) return Status::Ok();
  spdlog::info("the database is being rewritten after an erasure; changes wait until that is done");
  const auto begin = std::chrono::steady_clock::now();
  running_ = true;
  Status status = rows_.writer().RunAlone([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const uint64_t bytes, db.RewriteBytes());
    ENAMEL_RETURN_IF_ERROR(space_.RoomFor(bytes));
    return db.Rewrite();
  });
  running_ = false;
  if (status.ok()) status = RemoveMark(*mark);
  if (status.ok()) {
    std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    spdlog::info("rewrote the database in {:.1f} s", took.count());
  } else {
    spdlog::warn(
        "the database could not be rewritten after an erasure: {}. Copies of the erased data may "
        "remain in unused parts of it. The server tries again every hour and after its next start",
        status.message());
  }
  return status;
}

}  // namespace enamel::server
