#include "server/storage/people/roster_rows.h"

#include <map>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/people/cohort_rows.h"
#include "server/storage/people/people_rows.h"

// A roster, in one transaction.
namespace enamel::server {
namespace {

// All of them at once: a roster names most of a school, and a look-up for each of its lines would
// take longer.
Result<RosterFacts> FactsIn(Db& db) {
  RosterFacts out;
  static const std::string kPeople =
      std::string("SELECT ") + kPersonColumns + " FROM people p WHERE tenant = ?1";
  Query people(db, kPeople.c_str());
  ENAMEL_ASSIGN_OR_RETURN(const auto found, people.All<Person>());
  for (const Person& person : found) out.people.emplace(person.login, person);
  static const std::string kCohorts =
      std::string("SELECT ") + kCohortColumns + " FROM cohorts c WHERE tenant = ?1";
  Query cohorts(db, kCohorts.c_str());
  ENAMEL_ASSIGN_OR_RETURN(const auto named, cohorts.All<Cohort>());
  for (const Cohort& cohort : named) out.cohorts.emplace(cohort.name, cohort);
  Query members(db, "SELECT cohort, person FROM cohort_members WHERE tenant = ?1");
  while (members.Next()) out.members.emplace(members.Id(0), members.Id(1));
  ENAMEL_RETURN_IF_ERROR(members.status());
  return out;
}

Person NewPerson(const RosterRow& row) {
  Person out;
  out.id = Uuid::New();
  out.login = row.login;
  out.display_name = row.display_name.empty() ? row.login : row.display_name;
  out.role = row.role;
  // The list went through other hands.
  out.must_change_password = true;
  return out;
}

// `made`: who was new, by login; a person's further rows find the one that their first row made.
Status CarryOut(Db& db, const RosterStep& step, const std::map<std::string, Uuid>& cohorts,
                bool move, std::map<std::string, Uuid>& made, const Actor& by) {
  Uuid person;
  if (step.before) {
    person = step.before->id;
    if (step.renames) {
      ENAMEL_RETURN_IF_ERROR(RenamePerson(db, *step.before, step.row.display_name, by));
    }
  } else if (step.again) {
    person = made.at(step.row.login);
  } else {
    Person added = NewPerson(step.row);
    person = added.id;
    made[step.row.login] = person;
    ENAMEL_RETURN_IF_ERROR(InsertPerson(db, added, step.row.verifier, by));
  }
  if (!step.joins) return Status::Ok();
  for (const std::string& other : step.others) {
    if (move) ENAMEL_RETURN_IF_ERROR(DeleteMember(db, cohorts.at(other), person, by));
  }
  return InsertMember(db, cohorts.at(step.row.cohort), person, by);
}

Status CarryOut(Db& db, const RosterPlan& plan, const RosterFacts& facts, bool move,
                const Actor& by) {
  std::map<std::string, Uuid> cohorts;
  for (const auto& [name, cohort] : facts.cohorts) cohorts[name] = cohort.id;
  for (const std::string& name : plan.new_cohorts) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, InsertCohort(db, name, by));
    cohorts[name] = id;
  }
  std::map<std::string, Uuid> made;
  for (const RosterStep& step : plan.steps) {
    ENAMEL_RETURN_IF_ERROR(CarryOut(db, step, cohorts, move, made, by));
  }
  // An import that changed nothing is no event.
  const size_t created = plan.Count(RosterStep::Change::kCreate),
               updated = plan.Count(RosterStep::Change::kUpdate);
  if (created + updated == 0) return Status::Ok();
  return WriteAudit(
      db, by, "roster.import", "", "{}",
      JsonOf({{"created", std::to_string(created)},
              {"updated", std::to_string(updated)},
              {"unchanged", std::to_string(plan.Count(RosterStep::Change::kUnchanged))}}));
}

}  // namespace

Result<RosterPlan> RosterRows::ImportRoster(const std::vector<RosterRow>& rows, Import how,
                                            const Actor& by) {
  RosterPlan plan;
  auto make = [&](Db& db) -> Result<RosterFacts> {
    auto facts = FactsIn(db);
    if (facts.ok()) plan = PlanRoster(rows, *facts);
    return facts;
  };
  if (how.dry_run) {
    ENAMEL_ASSIGN_OR_RETURN(auto facts, rows_.Read(make));
    return plan;
  }
  Status status = rows_.Write([&](Db& db) -> Status {
    auto facts = make(db);
    // Plans again from the stored rows: the earlier dry run may be out of date. A plan with
    // problems changes nothing and is returned.
    if (!facts.ok() || !plan.problems.empty()) return facts.status();
    return CarryOut(db, plan, *facts, how.move, by);
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return plan;
}

}  // namespace enamel::server
