#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/storage/reference_store.h"
#include "server/training/revision.h"
#include "server/training/types.h"

namespace enamel::server {

struct AssignmentFilter {
  std::optional<Uuid> cohort{};
  std::optional<Uuid> of_instructor{};  // of this person's cohorts, and those for everybody
};

// Cohorts, what is assigned to them, and the cuts that attempts are compared with.
// A part of Store (store.h), which says what holds for all parts.
class TeachingStore : public ReferenceStore {
 public:
  virtual Result<Uuid> CreateCohort(const std::string& name, const Actor& by) = 0;
  virtual Result<Cohort> CohortById(const Uuid& id) = 0;
  // Errors: kConflict with field kStale, without one (the name is taken).
  virtual Result<Cohort> EditCohort(const Uuid& id, const CohortEdit& edit, int32_t revision,
                                    const Actor& by) = 0;
  // All or nothing; who is in already, or is not, stays so. Errors: kNotFound with the id that is
  // unknown.
  virtual Status ChangeMembers(const Uuid& cohort, const std::vector<Uuid>& add,
                               const std::vector<Uuid>& remove, const Actor& by) = 0;
  virtual Status AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by) = 0;
  virtual Result<std::vector<Cohort>> CohortsOf(
      const Uuid& person) = 0;  // as student or instructor
  virtual Result<std::vector<Cohort>> Cohorts() = 0;
  virtual Result<std::vector<Person>> CohortMembers(const Uuid& cohort) = 0;
  // True when the two share a cohort (a person shares one with itself only as a member of any).
  virtual Result<bool> ShareCohort(const Uuid& a, const Uuid& b) = 0;

  // Assignments; `revision` as for drafts (content_store.h). Errors: kNotFound (cohort,
  // station, assignment), kInvalidInput (no published exercise of that name). An assignment is of
  // the version that is the newest published one when it is made, or gets another exercise, and
  // stays with it: `version_id` of the row does not count.
  virtual Result<AssignmentRow> AddAssignment(const AssignmentRow& row, const Actor& by) = 0;
  virtual Result<AssignmentRow> ReplaceAssignment(const AssignmentRow& row, const Actor& by) = 0;
  // To another version of its exercise; tickets and attempts that are there keep theirs. `look_only`:
  // nothing changes, and the revision is not compared. Errors also: kInvalidInput with field
  // "exercise_id" (no published version of this exercise), kConflict with field "assignment" (an
  // exam that is open or being taken).
  virtual Result<AssignmentMove> MoveAssignment(const Uuid& id, const Uuid& version,
                                                int32_t revision, bool look_only,
                                                const Actor& by) = 0;
  // Errors also: kConflict with field "attempts" (some were made under it, which are released
  // through it; to end it, let it be due).
  virtual Status DeleteAssignment(const Uuid& id, int32_t revision, const Actor& by) = 0;
  virtual Result<AssignmentRow> AssignmentById(const Uuid& id) = 0;
  // By due time, those without one last.
  virtual Result<std::vector<AssignmentRow>> Assignments(const AssignmentFilter& filter) = 0;
  // Of the person's cohorts and for everybody, with a version that is not retired; exams first.
  virtual Result<std::vector<AssignedRow>> AssignmentsFor(const Uuid& person) = 0;
  // Releases every scored attempt under it; how many were not before.
  virtual Result<uint32_t> ReleaseAssignment(const Uuid& id, const Actor& by) = 0;
};

}  // namespace enamel::server
