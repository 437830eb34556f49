#include "server/storage/engine/move_marks.h"

#include <string>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

std::string NameOf(MoveRow row) { return row == MoveRow::kAway ? "moved" : "moving"; }

}  // namespace

Status PutMoveRow(Db& db, MoveRow row) {
  Query q(db,
          "INSERT INTO move_marks (tenant, mark) VALUES (?1, ?2) ON CONFLICT (tenant, mark) DO "
          "NOTHING");
  return q.Bind(NameOf(row)).Run();
}

Status DropMoveRow(Db& db, MoveRow row) {
  Query q(db, "DELETE FROM move_marks WHERE tenant = ?1 AND mark = ?2");
  return q.Bind(NameOf(row)).Run();
}

Result<bool> HasMoveRow(Db& db, MoveRow row) {
  Query q(db, "SELECT 1 FROM move_marks WHERE tenant = ?1 AND mark = ?2");
  const bool found = q.Bind(NameOf(row)).Next();
  if (!q.status().ok()) return q.status();
  return found;
}

Status MustNotBeMoved(Db& db) {
  ENAMEL_ASSIGN_OR_RETURN(const bool away, HasMoveRow(db, MoveRow::kAway));
  if (away) {
    return {Code::kConflict,
            "this school was moved out of this database (enamel-server move); go on in its new "
            "place. To go on here instead, without what has come there since and with who was "
            "erased there, delete the row \"moved\" of the table move_marks"};
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool coming, HasMoveRow(db, MoveRow::kComing));
  if (!coming) return Status::Ok();
  return {
      Code::kConflict,
      "this school is being moved into this database, and is half here; repeat the command that "
      "began it, which goes on where it stopped"};
}

}  // namespace enamel::server
