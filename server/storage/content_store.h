#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/storage/blob_store.h"
#include "server/training/types.h"

namespace enamel::server {

// Device profiles, scenes and exercises, and the blobs that hold them.
// A part of Store (store.h), which says what holds for all parts.
class ContentStore : public BlobStore {
 public:
  // Name, title and content of `row` count: a new version of the profile of this name when the
  // content differs from the newest one.
  virtual Status PutProfile(const ProfileRow& row, const Actor& by) = 0;
  virtual Result<std::vector<ProfileRow>> Profiles() = 0;  // newest versions, by name
  // Newest first; empty when there is no such profile.
  virtual Result<std::vector<ProfileRow>> ProfileVersions(const std::string& name) = 0;
  // About the newest version. The same content again: the row that is there. Errors: kNotFound (the
  // profile, the blob).
  virtual Result<ProfileReportRow> AddProfileReport(const ProfileReportRow& row,
                                                    const Actor& by) = 0;
  virtual Result<std::vector<ProfileReportRow>> ProfileReports(const std::string& profile) = 0;
  virtual Result<ProfileReportRow> ProfileReportById(const Uuid& id) = 0;
  // The same document again: the row that is there. Errors: kNotFound (the profile).
  virtual Result<CalibrationRow> AddCalibration(const CalibrationRow& row, const Actor& by) = 0;
  // Newest measurement first.
  virtual Result<std::vector<CalibrationRow>> Calibrations(const std::string& profile) = 0;
  virtual Status PutScene(const SceneRow& row, const Actor& by) = 0;
  virtual Result<std::vector<SceneRow>> Scenes() = 0;
  // The picture of a scene before it is cut, for all scenes with this volume.
  virtual Status PutSceneSurface(const Sha256& volume, const Sha256& surface) = 0;
  // A new version of the exercise of this name when the content differs from the newest one;
  // returns the row as stored. Assigned to `cohort` from then on unless a version of it is already,
  // which stays; a zero cohort: open to everybody; with any hand (HandsAllowed::kAny). A draft of that
  // name stays.
  virtual Result<ExerciseRow> PublishExercise(ExerciseRow row, const Uuid& cohort,
                                              const Actor& by) = 0;
  virtual Result<ExerciseRow> ExerciseById(const Uuid& id) = 0;
  virtual Result<ExerciseRow> ExerciseByContent(const Sha256& content) = 0;
  // The versions assigned to everybody or to a cohort of the person's that is in use, of each name the
  // newest first.
  virtual Result<std::vector<ExerciseRow>> ExercisesFor(const Uuid& person) = 0;
  virtual Result<std::vector<ExerciseRow>> AllExercises() = 0;
  // The newest version in this state of each name.
  virtual Result<std::vector<ExerciseRow>> ExercisesIn(ExerciseState state) = 0;
  // All of a name, the draft first, then newest first.
  virtual Result<std::vector<ExerciseRow>> ExerciseVersions(const std::string& name) = 0;
  // Whoever first puts or publishes an exercise of a name owns the name: an instructor, whose
  // exercises are private until they are shared; of anybody else it is the school's, and shared.
  // Changes that for all versions of the exercise's name. Errors: kNotFound, kInvalidInput with
  // field "owner_id" (not an instructor who may sign in).
  virtual Result<ExerciseRow> ShareExercise(const Uuid& id, const SharingEdit& edit,
                                            const Actor& by) = 0;
  // Drafts: name, title, content, scene and graded of `row` count. A `revision` that is not the
  // stored one: kConflict with field "revision", somebody else was first. Errors also: kConflict (a
  // draft of that name is there; not a draft), kNotFound (exercise, scene).
  virtual Result<ExerciseRow> PutDraft(const ExerciseRow& row, const Actor& by) = 0;
  virtual Result<ExerciseRow> ReplaceDraft(const ExerciseRow& row, const Actor& by) = 0;
  virtual Status DeleteDraft(const Uuid& id, int32_t revision, const Actor& by) = 0;
  // The draft becomes the next version; kConflict when it says what the newest one says.
  virtual Result<ExerciseRow> PublishDraft(const Uuid& id, int32_t revision, const Actor& by) = 0;
  // No version of the name can be assigned any more, until one is published or offered again. What is
  // assigned stays so and can be finished: retiring ends no assignment. `reason`, for the audit trail.
  // Errors also: kConflict, field "assignment", while an exam is open or being taken.
  virtual Status RetireExercise(const Uuid& id, const Actor& by,
                                const std::string& reason = {}) = 0;
  // What was retired is as it was before. Errors: kConflict where nothing of the name is retired.
  virtual Status OfferExerciseAgain(const Uuid& id, const Actor& by) = 0;
};

}  // namespace enamel::server
