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
  Status done;
  for (size_t i = 0; done.ok() && i < changes.size(); ++i) done = changes[i]->Run(*this);
  ran = done.ok();
  if (done.ok()) done = Commit();
  if (!done.ok()) {
    for (Change* change : changes) change->rows = 0;
  }
  return done;
}

}  // namespace enamel::sql
