#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

struct AssignmentFilter {
  std::optional<Uuid> cohort{};
  bool or_everybody = false;            // with a cohort: those for everybody too
  std::optional<Uuid> of_instructor{};  // of this person's cohorts, and those for everybody
};

// Assignments: the exercise, the cohort and the terms.
class AssignmentRows {
 public:
  explicit AssignmentRows(Transactions& rows) : rows_(rows) {}

  // Assignments; `revision` as for drafts (exercise_rows.h). Errors: kNotFound (cohort, station,
  // assignment), kInvalidInput (no published exercise of that name). A new assignment, or one that
  // gets another exercise, takes the newest published version and keeps it: `version_id` of the row
  // does not count.
  Result<AssignmentRow> AddAssignment(const AssignmentRow& row, const Actor& by);
  Result<AssignmentRow> ReplaceAssignment(const AssignmentRow& row, const Actor& by);
  // To another version of its exercise; tickets and attempts that are there keep theirs.
  // `look_only`: nothing changes, and the revision is not compared. Errors also: kInvalidInput with
  // field "exercise_id" (no published version of this exercise), kConflict with field "assignment"
  // (an exam that is open or being taken).
  Result<AssignmentMove> MoveAssignment(const Uuid& id, const Uuid& version, int32_t revision,
                                        bool look_only, const Actor& by);
  // Errors also: kConflict with field "attempts" (some were made under it, which are released
  // through it; to end it, let it be due).
  Status DeleteAssignment(const Uuid& id, int32_t revision, const Actor& by);
  Result<AssignmentRow> AssignmentById(const Uuid& id);
  // By due time, those without one last.
  Result<std::vector<AssignmentRow>> Assignments(const AssignmentFilter& filter);
  // Of the person's cohorts and for everybody, with a version that is not retired; exams first.
  Result<std::vector<AssignedRow>> AssignmentsFor(const Uuid& person);

 private:
  Transactions& rows_;
};

// Inside a transaction, for other rows.
//
Result<AssignmentRow> FindAssignment(Db& db, const Uuid& id);
// The audit row of an assignment that was just made.
Status NoteAssignment(Db& db, const Uuid& id, const Actor& by);
// kForbidden when the terms of the row's assignment leave no attempt to its person.
Status MayBeIssued(Db& db, const AttemptRow& row);

}  // namespace enamel::server
