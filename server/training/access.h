#pragma once

#include "server/training/types.h"

// Who may do what: the one place that decides. Pure functions; callers fetch the facts first.
//   student: own attempts, assigned exercises. instructor: attempts and references of own cohorts.
//   admin: all. A disabled person may nothing.
// `shares_cohort` is Store::ShareCohort(viewer, owner of the attempt).
namespace enamel::server {

bool CanSeeAttempt(const Person& viewer, const AttemptRow& attempt, bool shares_cohort);
// Score, surface, series: a student sees those of graded work only after release.
bool CanSeeScore(const Person& viewer, const AttemptRow& attempt, bool graded, bool shares_cohort);
bool CanReleaseAttempt(const Person& viewer, const AttemptRow& attempt, bool shares_cohort);
// Making an attempt the exercise's reference.
bool CanMarkReference(const Person& viewer, const AttemptRow& attempt, bool shares_cohort);
// Asking for a ticket whose attempt is meant as a reference cut.
bool CanRecordReference(const Person& viewer);
bool CanListCohorts(const Person& viewer);  // instructor: own; admin: all
bool CanListStations(const Person& viewer);
bool CanAdminister(const Person& viewer);  // people, cohorts, audit, jobs

}  // namespace enamel::server
