#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Exercises: drafts, versions, and who owns a name.
class ExerciseRows {
 public:
  explicit ExerciseRows(Transactions& rows) : rows_(rows) {}

  // A new version of the exercise of this name when the content differs from the newest one;
  // returns the row as stored. Assigned to `cohort` from then on unless a version of it is already,
  // which stays; a zero cohort: open to everybody; with any hand (HandsAllowed::kAny). A draft of
  // that name stays.
  Result<ExerciseRow> PublishExercise(ExerciseRow row, const Uuid& cohort, const Actor& by);
  Result<ExerciseRow> ExerciseById(const Uuid& id);
  Result<ExerciseRow> ExerciseByContent(const Sha256& content);
  // The versions assigned to everybody or to a cohort of the person's that is in use, of each name
  // the newest first.
  Result<std::vector<ExerciseRow>> ExercisesFor(const Uuid& person);
  Result<std::vector<ExerciseRow>> AllExercises();
  // The newest version in this state of each name.
  Result<std::vector<ExerciseRow>> ExercisesIn(ExerciseState state);
  // All of a name, the draft first, then newest first.
  Result<std::vector<ExerciseRow>> ExerciseVersions(const std::string& name);
  // The first person to put or publish an exercise of a name owns the name: an instructor, whose
  // exercises are private until they are shared; otherwise the school owns it, and it is shared.
  // Changes owner and sharing for all versions of the exercise's name. Errors: kNotFound,
  // kInvalidInput with field "owner_id" (not an instructor who may sign in).
  Result<ExerciseRow> ShareExercise(const Uuid& id, const SharingEdit& edit, const Actor& by);
  // Drafts: uses name, title, content, scene and graded of `row`. A `revision` that is not the
  // stored one: kConflict with field "revision", somebody else was first. Errors also: kConflict (a
  // draft of that name exists; not a draft), kNotFound (exercise, scene).
  Result<ExerciseRow> PutDraft(const ExerciseRow& row, const Actor& by);
  Result<ExerciseRow> ReplaceDraft(const ExerciseRow& row, const Actor& by);
  Status DeleteDraft(const Uuid& id, int32_t revision, const Actor& by);
  // The draft becomes the next version; kConflict when it says what the newest one says.
  Result<ExerciseRow> PublishDraft(const Uuid& id, int32_t revision, const Actor& by);
  // No version of the name can be assigned any more, until one is published or offered again.
  // Existing assignments stay and can be finished: retiring ends none. `reason`, for the audit
  // trail. Errors also: kConflict, field "assignment", while an exam is open or being taken.
  Status RetireExercise(const Uuid& id, const Actor& by, const std::string& reason = {});
  // Restores the retired versions. Errors: kConflict if no version of the name is retired.
  Status OfferExerciseAgain(const Uuid& id, const Actor& by);

 private:
  Transactions& rows_;
};

// Exercises with their owners, for statements that read ExerciseRow:
//   "SELECT " ENAMEL_EXERCISE_COLUMNS " FROM exercises e " ENAMEL_EXERCISE_OWNERS " WHERE …"
#define ENAMEL_EXERCISE_COLUMNS                                                               \
  "e.id, e.name, e.title, e.version, e.content, e.scene, e.graded, e.published_ms, e.state, " \
  "e.revision, o.owner, coalesce(w.display_name, ''), coalesce(o.shared, 1)"
#define ENAMEL_EXERCISE_OWNERS                                              \
  "LEFT JOIN exercise_owners o ON o.tenant = e.tenant AND o.name = e.name " \
  "LEFT JOIN people w ON w.tenant = o.tenant AND w.id = o.owner "

// Inside a transaction, for other rows.
//
Result<ExerciseRow> FindExercise(Db& db, const Uuid& id);
// The newest published version of a name; none: no version is offered.
Result<std::optional<ExerciseRow>> OfferedVersion(Db& db, const std::string& name);
// kConflict with field "assignment" while an exam with this exercise is open or being taken; of one
// assignment, when it is named.
Status NoExamMustBeOpen(Db& db, const std::string& name, const std::optional<Uuid>& assignment);

}  // namespace enamel::server
