#pragma once

#include "common/base/result.h"
#include "common/sql/db.h"

// Marks of a move (move.h) in a database that several servers share, so that no other server's
// folder opens the school there: a mark in a folder is visible only in that folder. Rows of the
// table `move_marks`. Private to server/storage.
namespace enamel::server {

enum class MoveRow {
  kAway,    // the school was moved out of here, or is just being
  kComing,  // it is being moved here, and is half there
};

// Again changes nothing. Errors: the database's.
Status PutMoveRow(sql::Db& db, MoveRow row);
Status DropMoveRow(sql::Db& db, MoveRow row);

Result<bool> HasMoveRow(sql::Db& db, MoveRow row);
// Errors: kConflict, with what to do.
Status MustNotBeMoved(sql::Db& db);

}  // namespace enamel::server
