#pragma once

#include <vector>

#include "common/base/result.h"
#include "server/http/caller.h"
#include "server/http/routes.h"

// Which cohorts and assignments a caller may see.
namespace enamel::server::http {

// An instructor's own; an admin's are all. Archived ones too.
Result<std::vector<Cohort>> VisibleCohorts(const Call& call, CohortRows& cohorts);
// The cohort {id}. Errors: kNotFound, the same for a missing cohort and one that the caller may not
// see.
Result<Cohort> VisibleCohort(const Call& call, CohortRows& cohorts);
// Whether the caller is a member, in whatever role.
Result<bool> IsInCohort(const Call& call, CohortRows& cohorts, const Uuid& cohort);
// The assignment {id}. Errors: as VisibleCohort.
Result<AssignmentRow> SeeAssignment(const Call& call, AssignmentRows& assignments,
                                    CohortRows& cohorts);

}  // namespace enamel::server::http
