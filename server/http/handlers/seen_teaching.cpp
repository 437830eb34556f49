#include "server/http/handlers/seen_teaching.h"

#include <algorithm>

#include "server/training/access.h"

namespace enamel::server::http {

Result<std::vector<Cohort>> VisibleCohorts(const Call& call, CohortRows& cohorts) {
  const Person& person = call.caller->person;
  return person.role == Role::kAdmin ? cohorts.Cohorts() : cohorts.CohortsOf(person.id);
}

Result<Cohort> VisibleCohort(const Call& call, CohortRows& cohorts) {
  // Through the list, so that one rule decides visibility.
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> visible, VisibleCohorts(call, cohorts));
  for (const Cohort& cohort : visible) {
    if (cohort.id == call.id) return cohort;
  }
  return Status{Code::kNotFound, "there is no such cohort", "id"};
}

Result<bool> IsInCohort(const Call& call, CohortRows& cohorts, const Uuid& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> own, cohorts.CohortsOf(call.caller->person.id));
  return std::ranges::find(own, cohort, &Cohort::id) != own.end();
}

Result<AssignmentRow> SeeAssignment(const Call& call, AssignmentRows& assignments,
                                    CohortRows& cohorts) {
  // The same answer for a missing assignment and one that the caller may not see: ids reveal
  // nothing.
  Status none{Code::kNotFound, "there is no such assignment", "id"};
  Result<AssignmentRow> row = assignments.AssignmentById(call.id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  ENAMEL_ASSIGN_OR_RETURN(bool in_cohort, IsInCohort(call, cohorts, row->cohort));
  if (CanSeeAssignment(call.caller->person, row->cohort, in_cohort)) return row;
  return none;
}

}  // namespace enamel::server::http
