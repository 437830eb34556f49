#include "server/storage/engine/move_marks.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

std::string NameOf(MoveRow row) { return row == MoveRow::kAway ? "moved" : "moving"; }

}  // namespace

Status PutMoveRow(Db& db, MoveRow row) {
  return Insert(db, "move_marks", "mark", NameOf(row), " ON CONFLICT (tenant, mark) DO NOTHING");
}

Status DropMoveRow(Db& db, MoveRow row) {
  Query q(db, "DELETE FROM move_marks WHERE tenant = ?1 AND mark = ?2");
  return q.Bind(NameOf(row)).Run();
}

Result<bool> HasMoveRow(Db& db, MoveRow row) {
  Query q(db, "SELECT 1 FROM move_marks WHERE tenant = ?1 AND mark = ?2");
  return q.Bind(NameOf(row)).Any();
}

Status MustNotBeMoved(Db& db) {
  ENAMEL_ASSIGN_OR_RETURN(const bool away, HasMoveRow(db, MoveRow::kAway));
  if (away) {
    return {Code::kConflict,
            "this school was moved out of this database (enamel-server move); use its new place. "
            "To use this one again, delete the row \"moved\" of the table move_marks: changes made "
            "in the new place are then missing here, and people erased there are not erased here"};
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool coming, HasMoveRow(db, MoveRow::kComing));
  if (!coming) return Status::Ok();
  return {Code::kConflict,
          "this school's move into this database is not finished; repeat the move command, which "
          "continues where it stopped"};
}

}  // namespace enamel::server
