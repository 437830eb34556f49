#include "server/http/handlers/seen_exercise.h"

#include <algorithm>

#include "server/training/access.h"

namespace enamel::server::http {
namespace {

std::string WhoseText(const ExerciseRow& row) {
  return "\"" + row.name + "\" belongs to " +
         (row.owner.IsZero() ? "the school: an admin changes it"
                             : row.owner_name + ", who changes it, or an admin");
}

}  // namespace

Result<std::vector<ExerciseRow>> VisibleExercises(const Call& call, ExerciseRows& exercises) {
  const Person& person = call.caller->person;
  return person.role == Role::kAdmin ? exercises.AllExercises() : exercises.ExercisesFor(person.id);
}

Result<ExerciseRow> VisibleExercise(const Call& call, AttemptRows& attempts_rows,
                                    ExerciseRows& exercises) {
  Status none{Code::kNotFound, "there is no such exercise", "id"};
  const Person& viewer = call.caller->person;
  Result<ExerciseRow> row = exercises.ExerciseById(call.id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  if (CanUseExercise(viewer, *row)) return row;
  if (row->state == ExerciseState::kDraft) return none;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> visible, VisibleExercises(call, exercises));
  if (std::ranges::find(visible, row->name, &ExerciseRow::name) != visible.end()) return row;
  AttemptFilter own;
  own.person = viewer.id;
  own.exercise = row->id;
  // Whether there is one, not how many.
  own.limit = 1;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AttemptRow> attempts, attempts_rows.Attempts(own));
  if (!attempts.empty()) return row;
  return none;
}

Result<ExerciseRow> ChangeableExercise(const Call& call, AttemptRows& attempts,
                                       ExerciseRows& exercises) {
  Result<ExerciseRow> row = VisibleExercise(call, attempts, exercises);
  if (!row.ok() || CanChangeExercise(call.caller->person, *row)) return row;
  return Status{Code::kForbidden,
                WhoseText(*row) + "; to change it, publish one of your own under another name"};
}

Status MayUseName(const Call& call, ExerciseRows& exercises, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> versions, exercises.ExerciseVersions(name));
  if (versions.empty() || CanChangeExercise(call.caller->person, versions.front())) return {};
  return {Code::kForbidden, WhoseText(versions.front()) + "; choose another name", "name"};
}

}  // namespace enamel::server::http
