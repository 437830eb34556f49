#include "server/storage/teaching/rubric_rows.h"

#include <optional>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/teaching/exercise_rows.h"
#include "server/training/revision.h"

// Corrections of the rubrics of published exercises.
namespace enamel::server {
namespace {

Result<std::vector<RubricRow>> FindRubrics(Db& db, const Uuid& exercise) {
  Query q(db,
          "SELECT exercise, version, content, reason, published_ms FROM rubrics WHERE tenant = ?1 "
          "AND exercise = ?2 ORDER BY version DESC");
  return q.Bind(exercise).All<RubricRow>();
}

std::string RubricJson(const RubricRow& row) {
  return JsonOf({{"version", std::to_string(row.version)},
                 {"content", row.content.Hex()},
                 {"reason", row.reason}});
}

}  // namespace

// The newest counts; none: the rubric in the exercise itself.
Result<std::optional<RubricRow>> RubricRows::RubricFor(const Uuid& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto rows, Rubrics(exercise));
  return rows.empty() ? std::optional<RubricRow>() : rows.front();
}

Result<std::vector<RubricRow>> RubricRows::Rubrics(const Uuid& exercise) {
  return rows_.Read([&](Db& db) { return FindRubrics(db, exercise); });
}

Result<RubricRow> RubricRows::PublishRubric(const RubricRow& row, const Actor& by) {
  if (!blobs_.Has(row.content)) {
    return Status(Code::kNotFound, "the rubric is not stored; put its blob first");
  }
  RubricRow added;
  Status status = rows_.Write([&](Db& db) -> Status {
    added = row;
    added.published_ms = NowMs();
    ENAMEL_ASSIGN_OR_RETURN(auto exercise, FindExercise(db, row.exercise));
    // A draft has no scores that a correction could change.
    if (exercise.state == ExerciseState::kDraft) {
      return Status(Code::kConflict, "this exercise is a draft; edit the rubric in it");
    }
    ENAMEL_ASSIGN_OR_RETURN(auto earlier, FindRubrics(db, row.exercise));
    if (!earlier.empty() && earlier.front().content == row.content) {
      return Status(Code::kConflict, "the current rubric is already the same");
    }
    if (!earlier.empty() && row.version != earlier.front().version + 1) {
      return Status(Code::kConflict,
                    "somebody else has corrected this rubric since (version " +
                        std::to_string(earlier.front().version) + "); look at it and try again",
                    std::string(kStale));
    }
    ENAMEL_RETURN_IF_ERROR(Insert(db, "rubrics", "exercise", added.exercise, "version",
                                  added.version, "content", added.content, "reason", added.reason,
                                  "published_ms", added.published_ms));
    return WriteAudit(db, by, "exercise.rubric", row.exercise.Text(),
                      earlier.empty() ? "{}" : RubricJson(earlier.front()), RubricJson(added));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return added;
}

}  // namespace enamel::server
