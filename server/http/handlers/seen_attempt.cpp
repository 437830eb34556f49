#include "server/http/handlers/seen_attempt.h"

#include "server/training/access.h"

namespace enamel::server::http {

Result<SeenAttempt> SeeAttempt(const Call& call, Store& store, const Uuid& attempt) {
  Status none{Code::kNotFound, "there is no such attempt", "id"};
  Result<AttemptRow> row = store.attempts.AttemptById(attempt);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  const Person& viewer = call.caller->person;
  Result<bool> shares = store.cohorts.ShareCohort(viewer.id, row->person);
  if (!shares.ok()) return shares.status();
  // As if it did not exist: an id must not reveal whether somebody has made an attempt.
  if (!CanSeeAttempt(viewer, *row, *shares)) return none;
  // Whether it counts is the exercise version's to say that the attempt was made of.
  Result<ExerciseRow> exercise = store.exercises.ExerciseById(row->exercise);
  if (!exercise.ok()) return exercise.status();
  return SeenAttempt{std::move(*row), *shares, exercise->graded};
}

Result<SeenAttempt> ReviewAttempt(const Call& call, Store& store, const Uuid& attempt) {
  Result<SeenAttempt> seen = SeeAttempt(call, store, attempt);
  if (!seen.ok()) return seen;
  if (CanReviewAttempt(call.caller->person, seen->row, seen->shares_cohort)) return seen;
  return Status{Code::kForbidden, "only instructors of this student's cohort can do this"};
}

Status RequireScored(const AttemptRow& row) {
  if (row.state == AttemptState::kScored) return {};
  return {Code::kConflict, std::string("expected a scored attempt, this one is ") +
                               AttemptStateName(row.state) +
                               (row.problem.empty() ? "; wait for the score" : ": " + row.problem)};
}

}  // namespace enamel::server::http
