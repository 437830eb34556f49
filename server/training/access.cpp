#include "server/training/access.h"

namespace enamel::server {
namespace {

// A disabled person may nothing at all, whatever the role says; every rule below goes through here
// or asks itself.
bool Is(const Person& viewer, Role role) { return !viewer.disabled && viewer.role == role; }

bool Supervises(const Person& viewer, bool teaches) {
  return Is(viewer, Role::kAdmin) || (Is(viewer, Role::kInstructor) && teaches);
}

bool Owns(const Person& viewer, const AttemptRow& attempt) {
  return !viewer.disabled && viewer.id == attempt.person;
}

}  // namespace

bool IsReleasedFirst(const AttemptRow& attempt, bool graded) {
  // After a restore nobody knows its terms. A score held back wrongly can be released; one shown
  // wrongly cannot be taken back.
  bool unknown_terms = (attempt.flags & kReadmitted) != 0 && !attempt.assignment;
  return graded || attempt.exam || unknown_terms;
}

bool CanSeeAttempt(const Person& viewer, const AttemptRow& attempt, bool teaches) {
  return Owns(viewer, attempt) || Supervises(viewer, teaches);
}

bool CanSeeScore(const Person& viewer, const AttemptRow& attempt, bool graded, bool teaches) {
  if (Supervises(viewer, teaches)) return true;
  if (!Owns(viewer, attempt)) return false;
  // Instructors who try an exercise themselves wait for nobody.
  return !IsReleasedFirst(attempt, graded) || attempt.released || !Is(viewer, Role::kStudent);
}

bool CanReleaseAttempt(const Person& viewer, const AttemptRow&, bool teaches) {
  return Supervises(viewer, teaches);
}

bool CanReviewAttempt(const Person& viewer, const AttemptRow&, bool teaches) {
  return Supervises(viewer, teaches);
}

bool CanSignOff(const Person& signer, const AttemptRow& attempt, bool teaches) {
  return Supervises(signer, teaches) && !Owns(signer, attempt);
}

bool CanEditAnnotation(const Person& viewer, const AnnotationRow& annotation, bool can_review) {
  // The author alone: a remark is shown under its author's name.
  return can_review && !viewer.disabled && viewer.id == annotation.author;
}

bool CanUseSavedText(const Person& viewer, const SavedText& text) {
  return CanChangeSavedText(viewer, text) || (Is(viewer, Role::kInstructor) && text.shared);
}

bool CanChangeSavedText(const Person& viewer, const SavedText& text) {
  return Is(viewer, Role::kAdmin) || (Is(viewer, Role::kInstructor) && viewer.id == text.owner);
}

bool CanAppeal(const Person& viewer, const AttemptRow& attempt) {
  return Owns(viewer, attempt) && attempt.released && attempt.state == AttemptState::kScored;
}

bool CanMarkReference(const Person& viewer, const AttemptRow& attempt, bool teaches) {
  return Supervises(viewer, teaches) ||
         // An instructor's own cut needs no cohort.
         (Is(viewer, Role::kInstructor) && Owns(viewer, attempt));
}

bool CanRecordReference(const Person& viewer) {
  return Is(viewer, Role::kInstructor) || Is(viewer, Role::kAdmin);
}

bool CanSeeDentist(const Person& viewer, const ReferenceRow& reference) {
  return reference.consent || CanRecordReference(viewer);
}

bool CanSeeReferenceCut(const Person& viewer, const ReferenceRow& reference,
                        const AttemptRow& compared, bool graded) {
  return reference.consent && reference.withdrawn_ms == 0 && Owns(viewer, compared) &&
         CanSeeScore(viewer, compared, graded, false);
}

Status CheckConsent(bool consent) {
  if (consent) return Status::Ok();
  return Status(Code::kConflict,
                "the dentist has not agreed: a reference shows a name and a cut to students; ask, "
                "and confirm it",
                "consent");
}

bool CanImportTeeth(const Person& viewer) {
  return Is(viewer, Role::kAdmin) || (Is(viewer, Role::kInstructor) && viewer.may_import_teeth);
}

bool CanEditExercises(const Person& viewer) { return CanRecordReference(viewer); }

bool CanUseExercise(const Person& viewer, const ExerciseRow& exercise) {
  return CanChangeExercise(viewer, exercise) || (Is(viewer, Role::kInstructor) && exercise.shared);
}

bool CanChangeExercise(const Person& viewer, const ExerciseRow& exercise) {
  return Is(viewer, Role::kAdmin) ||
         // A person of no id must not own the school's exercises.
         (Is(viewer, Role::kInstructor) && !exercise.owner.IsZero() && exercise.owner == viewer.id);
}

bool CanAssign(const Person& viewer, const Uuid& cohort, bool in_cohort) {
  return Is(viewer, Role::kAdmin) ||
         // To everybody is the school's to say, hence an admin's.
         (Is(viewer, Role::kInstructor) && in_cohort && !cohort.IsZero());
}

bool CanSeeAssignment(const Person& viewer, const Uuid& cohort, bool in_cohort) {
  return !viewer.disabled && (Is(viewer, Role::kAdmin) || in_cohort || cohort.IsZero());
}

bool CanListCohorts(const Person& viewer) { return CanRecordReference(viewer); }
bool CanListStations(const Person& viewer) { return CanRecordReference(viewer); }
bool CanAdminister(const Person& viewer) { return Is(viewer, Role::kAdmin); }

}  // namespace enamel::server
