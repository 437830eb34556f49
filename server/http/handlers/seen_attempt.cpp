#include "server/http/handlers/seen_attempt.h"

#include <algorithm>

#include "server/training/access.h"

namespace enamel::server::http {

Result<SeenAttempt> SeeAttempt(const Call& call, Store& store, const Uuid& attempt) {
  Status none{Code::kNotFound, "there is no such attempt", "id"};
  Result<AttemptRow> row = store.attempts.AttemptById(attempt);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  const Person& viewer = call.caller->person;
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, store.attempts.Teaches(viewer.id, row->id));
  // As if it did not exist: an id must not reveal whether somebody has made an attempt.
  if (!CanSeeAttempt(viewer, *row, teaches)) return none;
  if (viewer.role != Role::kStudent) {
    ENAMEL_ASSIGN_OR_RETURN(const auto hidden, store.markings.HiddenFrom(viewer.id));
    const auto found = hidden.find(attempt);
    if (found != hidden.end() && found->second == MarkingRows::Hidden::kAll) {
      return Status{Code::kForbidden,
                    "you mark this attempt blind: its page opens once all your marks are in"};
    }
  }
  // Whether it counts is the exercise version's to say that the attempt was made of.
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow exercise, store.exercises.ExerciseById(row->exercise));
  return SeenAttempt{std::move(*row), teaches, exercise.graded};
}

Result<SeenAttempt> ReviewAttempt(const Call& call, Store& store, const Uuid& attempt) {
  Result<SeenAttempt> seen = SeeAttempt(call, store, attempt);
  ENAMEL_RETURN_IF_ERROR(seen.status());
  if (CanReviewAttempt(call.caller->person, seen->row, seen->teaches)) return seen;
  return Status{Code::kForbidden, "only instructors of this attempt's cohort can do this"};
}

void NarrowToTaught(const Call& call, AttemptFilter& filter) {
  const Person& viewer = call.caller->person;
  // Their own they see in any case.
  if (viewer.role == Role::kInstructor && filter.person != viewer.id) filter.taught_by = viewer.id;
}

Result<bool> IsCallersReference(const Call& call, Store& store, const Uuid& attempt) {
  const Person& viewer = call.caller->person;
  const Result<AttemptRow> cut = store.attempts.AttemptById(attempt);
  if (cut.status().code() == Code::kNotFound) return false;
  ENAMEL_RETURN_IF_ERROR(cut.status());
  ENAMEL_ASSIGN_OR_RETURN(const auto counting, store.references.Counting(cut->exercise));
  const auto reference = std::ranges::find(counting, attempt, &ReferenceRow::attempt);
  if (reference == counting.end()) return false;
  ENAMEL_ASSIGN_OR_RETURN(const ExerciseRow exercise, store.exercises.ExerciseById(cut->exercise));
  AttemptFilter own;
  own.person = viewer.id;
  own.exercise = cut->exercise;
  own.state = AttemptState::kScored;
  own.limit = 200;
  ENAMEL_ASSIGN_OR_RETURN(const auto attempts, store.attempts.Attempts(own));
  for (const AttemptRow& row : attempts) {
    if (!CanSeeReferenceCut(viewer, *reference, row, exercise.graded)) continue;
    ENAMEL_ASSIGN_OR_RETURN(const AttemptResult result, store.results.ResultOf(row.id));
    if (result.reference == attempt) return true;
  }
  return false;
}

Status ScoresMustNotBeHidden(const Call& call, Store& store, std::span<const Uuid> attempts) {
  if (call.caller->person.role == Role::kStudent) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto hidden, store.markings.HiddenFrom(call.caller->person.id));
  if (std::ranges::none_of(attempts, [&](const Uuid& id) { return hidden.contains(id); })) {
    return Status::Ok();
  }
  return {Code::kForbidden,
          "you mark this attempt blind: its score shows once every marker is done"};
}

Status RequireScored(const AttemptRow& row) {
  if (row.state == AttemptState::kScored) return {};
  return {Code::kConflict, std::string("expected a scored attempt, this one is ") +
                               AttemptStateName(row.state) +
                               (row.problem.empty() ? "; wait for the score" : ": " + row.problem)};
}

}  // namespace enamel::server::http
