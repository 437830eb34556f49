#include "common/sql/db.h"

#include "common/sql/query.h"

namespace enamel::sql {

Status Change::Run(Db& db) {
  rows = 0;
  Query q(db, sql);
  bind(q);
  ENAMEL_RETURN_IF_ERROR(q.Run());
  rows = db.Changes();
  return Status::Ok();
}

Status Db::RunAndCommit(std::span<Change* const> changes, bool& ran) {
  ran = false;
  for (Change* change : changes) ENAMEL_RETURN_IF_ERROR(change->Run(*this));
  ran = true;
  return Commit();
}

}  // namespace enamel::sql
