#include "server/storage/attempts/attempt_flags.h"

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"

namespace enamel::server {

// Scores and flags change in several places and each raises it, so that no edit overwrites what
// its author has not seen.
Status RaiseRevision(Db& db, const Uuid& attempt) {
  Query q(db, "UPDATE attempts SET revision = revision + 1 WHERE tenant = ?1 AND id = ?2");
  return q.Bind(attempt).Run();
}

Status SetFlags(Db& db, const Uuid& attempt, uint32_t flags, const std::string& reason,
                const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
  if ((row.flags & flags) == flags) return Status::Ok();
  Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, flags).Run());
  ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
  std::string names;
  for (const char* name : AttemptFlagNames(flags))
    names += (names.empty() ? "" : " ") + std::string(name);
  return WriteAudit(db, by, "attempt.flag", attempt.Text(), "{}",
                    JsonOf({{"flags", names}, {"reason", reason}}));
}

Status PutFlag(Db& db, const Uuid& attempt, AttemptFlag flag, bool found) {
  Query q(db,
          "UPDATE attempts SET flags = (flags - (flags & ?3)) | ?4 WHERE tenant = ?1 AND id = ?2");
  return q.Bind(attempt, flag, found ? int64_t{flag} : 0).Run();
}

// The revision rises: an override that was begun before the release was seen is refused.
Status SetReleased(Db& db, const Uuid& attempt, bool released, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
  Query q(db, "UPDATE attempts SET released = ?3 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, released).Run());
  return WriteAudit(db, by, released ? "attempt.release" : "attempt.unrelease", attempt.Text(),
                    JsonOf({{"released", released ? "no" : "yes"}}),
                    JsonOf({{"released", released ? "yes" : "no"}}));
}

}  // namespace enamel::server
