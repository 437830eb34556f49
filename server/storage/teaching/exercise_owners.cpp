#include "server/storage/teaching/exercise_owners.h"

#include <optional>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/teaching/exercise_rows.h"

// The owner of an exercise, by its name, and whether others may use it.
namespace enamel::server {
namespace {

Result<bool> IsInstructor(Db& db, const Uuid& person, bool may_be_disabled) {
  Query q(db, "SELECT disabled FROM people WHERE tenant = ?1 AND id = ?2 AND role = " +
                  Sql(Role::kInstructor));
  const bool found = q.Bind(person).Next() && (may_be_disabled || q.Int(0) == 0);
  ENAMEL_RETURN_IF_ERROR(q.status());
  return found;
}

std::optional<Uuid> OrNone(const Uuid& owner) {
  return owner.IsZero() ? std::optional<Uuid>() : owner;
}

std::string OwnerJson(const std::string& name, const Uuid& owner, bool shared) {
  return JsonOf({{"name", name},
                 {"owner", owner.IsZero() ? "" : owner.Text()},
                 {"shared", shared ? "yes" : "no"}});
}

std::string SharingJson(const ExerciseRow& row) {
  return OwnerJson(row.name, row.owner, row.shared);
}

}  // namespace

Status OwnName(Db& db, const std::string& name, const Actor& by) {
  // What an admin or the command line makes is the school's, and for all who teach there.
  ENAMEL_ASSIGN_OR_RETURN(const bool owns, IsInstructor(db, by.person, true));
  const Uuid owner = owns ? by.person : Uuid{};
  ENAMEL_RETURN_IF_ERROR(Insert(db, "exercise_owners", "name", name, "owner", OrNone(owner),
                                "shared", !owns, " ON CONFLICT DO NOTHING"));
  if (db.Changes() == 0) return Status::Ok();
  return WriteAudit(db, by, "owner.set", name, "{}", OwnerJson(name, owner, !owns));
}

Status FreeUnusedName(Db& db, const std::string& name, const Actor& by) {
  Query q(db,
          "DELETE FROM exercise_owners WHERE tenant = ?1 AND name = ?2 AND NOT EXISTS (SELECT 1 "
          "FROM exercises e WHERE e.tenant = ?1 AND e.name = ?2)");
  ENAMEL_RETURN_IF_ERROR(q.Bind(name).Run());
  return db.Changes() == 0 ? Status::Ok() : WriteAudit(db, by, "owner.free", name, "{}", "{}");
}

Status GiveNamesToSchool(Db& db, const Uuid& owner, const Actor& by) {
  std::vector<std::pair<std::string, bool>> names;
  {
    Query q(db,
            "SELECT name, shared FROM exercise_owners WHERE tenant = ?1 AND owner = ?2 ORDER BY "
            "name");
    for (q.Bind(owner); q.Next();) names.emplace_back(q.Text(0), q.Int(1) != 0);
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  Query q(db, "UPDATE exercise_owners SET owner = NULL WHERE tenant = ?1 AND owner = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(owner).Run());
  for (const auto& [name, shared] : names) {
    ENAMEL_RETURN_IF_ERROR(WriteAudit(db, by, "owner.set", name, OwnerJson(name, owner, shared),
                                      OwnerJson(name, Uuid{}, shared)));
  }
  return Status::Ok();
}

Status ShareName(Db& db, const Uuid& exercise, const SharingEdit& edit, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const auto before, FindExercise(db, exercise));
  ExerciseRow row = before;
  row.shared = edit.shared.value_or(before.shared);
  row.owner = edit.owner.value_or(before.owner);
  if (row.owner != before.owner && !row.owner.IsZero()) {
    ENAMEL_ASSIGN_OR_RETURN(const bool fits, IsInstructor(db, row.owner, false));
    if (!fits) {
      return Status(Code::kInvalidInput,
                    "expected an instructor who may sign in, or none for the school; found " +
                        row.owner.Text(),
                    "owner_id");
    }
  }
  if (row.shared == before.shared && row.owner == before.owner) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(Insert(db, "exercise_owners", "name", row.name, "owner", OrNone(row.owner),
                                "shared", row.shared,
                                " ON CONFLICT (tenant, name) DO UPDATE SET owner = excluded.owner, "
                                "shared = excluded.shared"));
  return WriteAuditAbout(db, SubjectOf("owner", row.name), by, "exercise.share", exercise.Text(),
                         SharingJson(before), SharingJson(row));
}

}  // namespace enamel::server
