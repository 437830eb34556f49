#pragma once

#include "common/base/result.h"
#include "server/training/types.h"

// Who may do what: the one place that decides. Pure functions; callers fetch the facts first.
//   student: own attempts, assigned exercises. instructor: attempts and references of own cohorts.
//   admin: all. A disabled person: nothing.
// `teaches` is AttemptRows::Teaches(viewer, attempt): its cohort is the viewer's.
namespace enamel::server {

bool CanSeeAttempt(const Person& viewer, const AttemptRow& attempt, bool teaches);
// Whether the student sees the score only after release: graded work, exams, and attempts whose
// terms a restore forgot. `graded`: its exercise is.
bool IsReleasedFirst(const AttemptRow& attempt, bool graded);
// Score, surface, series, annotations: a student sees them at once, or after release.
bool CanSeeScore(const Person& viewer, const AttemptRow& attempt, bool graded, bool teaches);
bool CanReleaseAttempt(const Person& viewer, const AttemptRow& attempt, bool teaches);
// Overriding, annotating, flagging, scoring again, answering an appeal.
// Whether this person may sign the attempt at the chair as its second person.
bool CanSignOff(const Person& signer, const AttemptRow& attempt, bool teaches);
bool CanReviewAttempt(const Person& viewer, const AttemptRow& attempt, bool teaches);
// Own remarks only; who wrote one and may no longer review cannot.
bool CanEditAnnotation(const Person& viewer, const AnnotationRow& annotation, bool can_review);
// Others who teach may use a shared text; its owner and admins may change it.
bool CanUseSavedText(const Person& viewer, const SavedText& text);
bool CanChangeSavedText(const Person& viewer, const SavedText& text);
// The attempt's person, once the score is released.
bool CanAppeal(const Person& viewer, const AttemptRow& attempt);
// Making an attempt the exercise's reference, and withdrawing it.
bool CanMarkReference(const Person& viewer, const AttemptRow& attempt, bool teaches);
// Asking for a ticket whose attempt is meant as a reference cut.
bool CanRecordReference(const Person& viewer);
// A cut becomes a reference only when its dentist agrees to being named and to the cut being used.
// Errors: kConflict, field "consent".
Status CheckConsent(bool consent);
// The dentist's name at a reference: students see it with the dentist's consent.
bool CanSeeDentist(const Person& viewer, const ReferenceRow& reference);
// Playing back how the exercise's reference was cut, with its forces: a person whose own attempt was scored
// against it (`compared`), once that score shows, if the dentist has consented. `graded`: the exercise is.
bool CanSeeReferenceCut(const Person& viewer, const ReferenceRow& reference,
                        const AttemptRow& compared, bool graded);
// Making exercises of one's own: instructors and admins, whatever their cohorts.
bool CanEditExercises(const Person& viewer);
// Making teeth of meshes: admins, and instructors whom an admin allowed it.
bool CanImportTeeth(const Person& viewer);
// Reading an exercise, its drafts too, and assigning it: its owner, instructors when it is shared,
// admins. A person also sees exercises assigned to them.
bool CanUseExercise(const Person& viewer, const ExerciseRow& exercise);
// Drafts and versions of its name, its rubric, retiring and sharing it: who owns it, and admins.
// What belongs to nobody is the school's, hence the admins'.
bool CanChangeExercise(const Person& viewer, const ExerciseRow& exercise);
// `in_cohort`: whether the viewer is in the assignment's cohort. For everybody (zero cohort):
// admin.
bool CanAssign(const Person& viewer, const Uuid& cohort, bool in_cohort);
bool CanSeeAssignment(const Person& viewer, const Uuid& cohort, bool in_cohort);
bool CanListCohorts(const Person& viewer);  // instructor: own; admin: all
bool CanListStations(const Person& viewer);
bool CanAdminister(const Person& viewer);  // people, cohorts, audit, jobs

}  // namespace enamel::server
