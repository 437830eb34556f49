#include "server/storage/people/cohort_rows.h"

#include <map>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/people/people_rows.h"

// Cohorts and their members.
namespace enamel::server {
namespace {

Result<Cohort> FindCohort(Db& db, const Uuid& id) {
  Query q(db, std::string("SELECT ") + kCohortColumns +
                  " FROM cohorts c WHERE tenant = ?1 AND id = ?2");
  return q.Bind(id).One<Cohort>("no cohort " + id.Text());
}

Status UpdateCohort(Db& db, const Cohort& before, Cohort& after, const Actor& by) {
  if (after.name == before.name && after.archived_ms == before.archived_ms) return Status::Ok();
  ++after.revision;
  Query q(db,
          "UPDATE cohorts SET name = ?3, archived_ms = ?4, revision = ?5 WHERE tenant = ?1 AND "
          "id = ?2");
  q.Bind(after.id, after.name, after.archived_ms, after.revision);
  ENAMEL_RETURN_IF_ERROR(
      Explain(q.Run(), "there is already a cohort named \"" + after.name + "\""));
  auto json = [](const Cohort& cohort) {
    return JsonOf({{"name", cohort.name}, {"archived", cohort.archived_ms != 0 ? "yes" : "no"}});
  };
  return WriteAudit(db, by, "cohort.edit", after.id.Text(), json(before), json(after));
}

std::string MemberSubject(const Uuid& cohort, const Uuid& person) {
  return SubjectOf("member", cohort.Text() + " " + person.Text());
}

}  // namespace

Result<Uuid> InsertCohort(Db& db, const std::string& name, const Actor& by) {
  Uuid id = Uuid::New();
  ENAMEL_RETURN_IF_ERROR(Explain(Insert(db, "cohorts", "id", id, "name", name),
                                 "there is already a cohort named \"" + name + "\""));
  ENAMEL_RETURN_IF_ERROR(
      WriteAudit(db, by, "cohort.create", id.Text(), "{}", JsonOf({{"name", name}})));
  return id;
}

Status DeleteMember(Db& db, const Uuid& cohort, const Uuid& person, const Actor& by) {
  Query q(db, "DELETE FROM cohort_members WHERE tenant = ?1 AND cohort = ?2 AND person = ?3");
  ENAMEL_RETURN_IF_ERROR(q.Bind(cohort, person).Run());
  if (db.Changes() == 0) return Status::Ok();
  return WriteAuditAbout(db, MemberSubject(cohort, person), by, "cohort.remove", cohort.Text(),
                         JsonOf({{"person", person.Text()}}), "{}");
}

Status InsertMember(Db& db, const Uuid& cohort, const Uuid& person, const Actor& by) {
  Status status =
      Insert(db, "cohort_members", "cohort", cohort, "person", person, " ON CONFLICT DO NOTHING");
  // The foreign keys show that one of the two is missing, but not which.
  if (status.code() == Code::kConflict) {
    return Status(Code::kNotFound, "no cohort " + cohort.Text() + " or no person " + person.Text());
  }
  ENAMEL_RETURN_IF_ERROR(status);
  if (db.Changes() == 0) return Status::Ok();
  return WriteAuditAbout(db, MemberSubject(cohort, person), by, "cohort.add", cohort.Text(), "{}",
                         JsonOf({{"person", person.Text()}}));
}

Result<Uuid> CohortRows::CreateCohort(const std::string& name, const Actor& by) {
  Result<Uuid> id = Uuid{};
  Status status = rows_.Write([&](Db& db) -> Status {
    id = InsertCohort(db, name, by);
    return id.status();
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return id;
}

Result<Cohort> CohortRows::CohortById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindCohort(db, id); });
}

Result<Cohort> CohortRows::EditCohort(const Uuid& id, const CohortEdit& edit, int32_t revision,
                                      const Actor& by) {
  Cohort after;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto before, FindCohort(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(before.revision, revision));
    after = before;
    if (edit.name) after.name = *edit.name;
    // Archiving an archived cohort keeps the first time.
    if (edit.archived && *edit.archived != (before.archived_ms != 0)) {
      after.archived_ms = *edit.archived ? NowMs() : 0;
    }
    return UpdateCohort(db, before, after, by);
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return after;
}

Status CohortRows::ChangeMembers(const Uuid& cohort, const std::vector<Uuid>& add,
                                 const std::vector<Uuid>& remove, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    if (auto found = FindCohort(db, cohort); !found.ok()) return found.status();
    // All are looked up before one is changed, so that a refusal names the person.
    for (const auto* people : {&add, &remove}) {
      for (const Uuid& person : *people) {
        if (auto found = FindPerson(db, person); !found.ok()) return found.status();
      }
    }
    for (const Uuid& person : add) {
      ENAMEL_RETURN_IF_ERROR(InsertMember(db, cohort, person, by));
    }
    for (const Uuid& person : remove) {
      ENAMEL_RETURN_IF_ERROR(DeleteMember(db, cohort, person, by));
    }
    return Status::Ok();
  });
}

Status CohortRows::AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status { return InsertMember(db, cohort, person, by); });
}

Result<std::vector<Cohort>> CohortRows::CohortsOf(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<Cohort>> {
    Query q(db,
            std::string("SELECT ") + kCohortColumns +
                " FROM cohort_members m JOIN cohorts c ON c.tenant = m.tenant AND c.id = m.cohort "
                "WHERE m.tenant = ?1 AND m.person = ?2 ORDER BY c.name");
    return q.Bind(person).All<Cohort>();
  });
}

Result<std::vector<Cohort>> CohortRows::Cohorts() {
  return rows_.Read([&](Db& db) -> Result<std::vector<Cohort>> {
    Query q(db, std::string("SELECT ") + kCohortColumns +
                    " FROM cohorts c WHERE tenant = ?1 ORDER BY name");
    return q.All<Cohort>();
  });
}

Result<std::vector<CohortSize>> CohortRows::SizesOf(const std::vector<Uuid>& cohorts) {
  return rows_.Read([&](Db& db) -> Result<std::vector<CohortSize>> {
    std::map<Uuid, uint32_t> staff;
    std::map<Uuid, std::vector<std::string>> instructors;
    // CROSS keeps SQLite from beginning with the members, of whom most are students.
    Query q(db,
            "SELECT m.cohort, p.role, p.display_name FROM people p CROSS JOIN cohort_members m "
            "WHERE p.tenant = ?1 AND p.role IN (" +
                Sql(Role::kInstructor) + ", " + Sql(Role::kAdmin) +
                ") AND m.tenant = p.tenant AND m.person = p.id ORDER BY p.display_name");
    while (q.Next()) {
      ++staff[q.Id(0)];
      if (q.Int(1) == static_cast<int64_t>(Role::kInstructor)) {
        instructors[q.Id(0)].push_back(q.Text(2));
      }
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    std::vector<CohortSize> out;
    for (const Uuid& cohort : cohorts) {
      Query members(db, "SELECT count(*) FROM cohort_members WHERE tenant = ?1 AND cohort = ?2");
      members.Bind(cohort).Next();
      ENAMEL_RETURN_IF_ERROR(members.status());
      out.push_back({static_cast<uint32_t>(members.Int(0)) - staff[cohort], instructors[cohort]});
    }
    return out;
  });
}

// Those who teach come before those who are taught.
Result<std::vector<Person>> CohortRows::CohortMembers(const Uuid& cohort) {
  return rows_.Read([&](Db& db) -> Result<std::vector<Person>> {
    Query q(db,
            std::string("SELECT ") + kPersonColumns +
                " FROM cohort_members m JOIN people p ON p.tenant = m.tenant AND p.id = m.person "
                "WHERE m.tenant = ?1 AND m.cohort = ?2 ORDER BY p.role DESC, p.display_name");
    return q.Bind(cohort).All<Person>();
  });
}

}  // namespace enamel::server
