#include "server/storage/engine/row_checks.h"

#include "server/training/revision.h"

namespace enamel::server {

Status Explain(Status status, const std::string& conflict) {
  if (status.code() != Code::kConflict) return status;
  return Status(Code::kConflict, conflict);
}

Status MustHaveChanged(sql::Db& db, const std::string& what) {
  if (db.Changes() > 0) return Status::Ok();
  return Status(Code::kNotFound, "no " + what);
}

Status MustBeRevision(int32_t stored, int32_t seen) {
  if (stored == seen) return Status::Ok();
  return Status(
      Code::kConflict,
      "somebody else has changed this since you loaded it; load it again and repeat your change",
      std::string(kStale));
}

}  // namespace enamel::server
