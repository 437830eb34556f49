#include "server/training/access.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

Person Of(Role role, uint8_t id) {
  Person out;
  out.id.bytes[0] = id;
  out.role = role;
  return out;
}

const Person kOwner = Of(Role::kStudent, 1);
const Person kOtherStudent = Of(Role::kStudent, 2);
const Person kInstructor = Of(Role::kInstructor, 3);
const Person kAdmin = Of(Role::kAdmin, 4);

AttemptRow AttemptOfOwner(bool released = false) {
  AttemptRow out;
  out.person = kOwner.id;
  out.released = released;
  return out;
}

TEST(AccessTest, StudentSeesOwnAttemptsOnlyEvenInASharedCohort) {
  EXPECT_TRUE(CanSeeAttempt(kOwner, AttemptOfOwner(), false));
  EXPECT_FALSE(CanSeeAttempt(kOtherStudent, AttemptOfOwner(), true));
}

TEST(AccessTest, ExamIsHiddenUntilReleasedAlsoWhenTheExerciseIsPractice) {
  AttemptRow exam = AttemptOfOwner();
  EXPECT_TRUE(CanSeeScore(kOwner, exam, false, true));
  exam.exam = true;
  EXPECT_FALSE(CanSeeScore(kOwner, exam, false, true));
  EXPECT_TRUE(CanSeeScore(kInstructor, exam, false, true));
  exam.released = true;
  EXPECT_TRUE(CanSeeScore(kOwner, exam, false, true));
}

TEST(AccessTest, ReviewIsForInstructorsOfTheCohortAndAdmins) {
  EXPECT_TRUE(CanReviewAttempt(kInstructor, AttemptOfOwner(), true));
  EXPECT_TRUE(CanReviewAttempt(kAdmin, AttemptOfOwner(), false));
  EXPECT_FALSE(CanReviewAttempt(kInstructor, AttemptOfOwner(), false));
  EXPECT_FALSE(CanReviewAttempt(kOwner, AttemptOfOwner(), true));
  AnnotationRow remark;
  remark.author = kInstructor.id;
  EXPECT_TRUE(CanEditAnnotation(kInstructor, remark, true));
  EXPECT_FALSE(CanEditAnnotation(kInstructor, remark, false)) << "no longer of the cohort";
  EXPECT_FALSE(CanEditAnnotation(kAdmin, remark, true)) << "somebody else's words";
}

TEST(AccessTest, SavedTextIsItsOwnersAndOthersUseItWhenItIsShared) {
  SavedText text;
  text.owner = kInstructor.id;
  const Person other = Of(Role::kInstructor, 5);
  EXPECT_TRUE(CanChangeSavedText(kInstructor, text) && CanChangeSavedText(kAdmin, text));
  EXPECT_FALSE(CanUseSavedText(other, text));
  text.shared = true;
  EXPECT_TRUE(CanUseSavedText(other, text));
  EXPECT_FALSE(CanChangeSavedText(other, text));
  text.owner = kOwner.id;
  EXPECT_FALSE(CanUseSavedText(kOwner, text)) << "a student, who was an instructor when saving it";
}

TEST(AccessTest, ExerciseIsChangedByItsOwnerAndAdminsAndUsedByInstructorsWhenShared) {
  ExerciseRow own;
  own.owner = kInstructor.id;
  own.shared = false;
  const Person other = Of(Role::kInstructor, 5);
  EXPECT_TRUE(CanChangeExercise(kInstructor, own) && CanUseExercise(kInstructor, own));
  EXPECT_TRUE(CanChangeExercise(kAdmin, own) && CanUseExercise(kAdmin, own));
  EXPECT_FALSE(CanChangeExercise(other, own) || CanUseExercise(other, own));
  own.shared = true;
  EXPECT_FALSE(CanChangeExercise(other, own));
  EXPECT_TRUE(CanUseExercise(other, own));
  EXPECT_FALSE(CanUseExercise(kOtherStudent, own)) << "students see what is assigned to them";
  own.owner = kOwner.id;
  EXPECT_FALSE(CanChangeExercise(kOwner, own)) << "was an instructor, is a student now";
  Person gone = kInstructor;
  gone.disabled = true;
  own.owner = gone.id;
  EXPECT_FALSE(CanChangeExercise(gone, own) || CanUseExercise(gone, own));
}

TEST(AccessTest, SchoolsExerciseIsAnAdminsToChange) {
  const ExerciseRow schools;
  EXPECT_FALSE(CanChangeExercise(kInstructor, schools));
  EXPECT_FALSE(CanChangeExercise(Of(Role::kInstructor, 0), schools));
  EXPECT_TRUE(CanUseExercise(kInstructor, schools));
  EXPECT_TRUE(CanChangeExercise(kAdmin, schools));
}

TEST(AccessTest, AppealIsForTheOwnerOfAReleasedScore) {
  AttemptRow attempt = AttemptOfOwner(true);
  EXPECT_FALSE(CanAppeal(kOwner, attempt)) << "not scored";
  attempt.state = AttemptState::kScored;
  EXPECT_TRUE(CanAppeal(kOwner, attempt));
  EXPECT_FALSE(CanAppeal(kOtherStudent, attempt));
  EXPECT_FALSE(CanAppeal(kInstructor, attempt));
  attempt.released = false;
  EXPECT_FALSE(CanAppeal(kOwner, attempt));
}

TEST(AccessTest, InstructorAssignsToOwnCohortsAndOnlyAnAdminToEverybody) {
  Uuid cohort = kOwner.id, everybody;
  EXPECT_TRUE(CanAssign(kInstructor, cohort, true));
  EXPECT_FALSE(CanAssign(kInstructor, cohort, false));
  EXPECT_FALSE(CanAssign(kInstructor, everybody, false));
  EXPECT_TRUE(CanAssign(kAdmin, everybody, false));
  EXPECT_FALSE(CanAssign(kOwner, cohort, true));
  EXPECT_TRUE(CanSeeAssignment(kOwner, cohort, true));
  EXPECT_TRUE(CanSeeAssignment(kOwner, everybody, false));
  EXPECT_FALSE(CanSeeAssignment(kOwner, cohort, false));
  Person disabled = kAdmin;
  disabled.disabled = true;
  EXPECT_FALSE(CanSeeAssignment(disabled, everybody, false));
  EXPECT_FALSE(CanAssign(disabled, cohort, true));
  EXPECT_FALSE(CanEditExercises(disabled));
  EXPECT_FALSE(CanEditExercises(kOwner));
  EXPECT_TRUE(CanEditExercises(kInstructor));
}

TEST(AccessTest, DentistIsNamedToStudentsWithConsentOnly) {
  ReferenceRow reference;
  EXPECT_TRUE(CanSeeDentist(kOwner, reference));
  reference.consent = false;
  EXPECT_FALSE(CanSeeDentist(kOwner, reference));
  EXPECT_TRUE(CanSeeDentist(kInstructor, reference));
}

TEST(AccessTest, InstructorSeesAttemptsOfOwnCohortsOnly) {
  EXPECT_TRUE(CanSeeAttempt(kInstructor, AttemptOfOwner(), true));
  EXPECT_FALSE(CanSeeAttempt(kInstructor, AttemptOfOwner(), false));
  EXPECT_FALSE(CanReleaseAttempt(kInstructor, AttemptOfOwner(), false));
}

TEST(AccessTest, GradedScoreIsHiddenFromItsStudentUntilReleased) {
  EXPECT_FALSE(CanSeeScore(kOwner, AttemptOfOwner(false), true, true));
  EXPECT_TRUE(CanSeeScore(kOwner, AttemptOfOwner(true), true, true));
  EXPECT_TRUE(CanSeeScore(kOwner, AttemptOfOwner(false), false, true));
  EXPECT_FALSE(CanSeeScore(kOtherStudent, AttemptOfOwner(true), false, true));
}

TEST(AccessTest, AdminSeesAndAdministersAll) {
  EXPECT_TRUE(CanSeeScore(kAdmin, AttemptOfOwner(), true, false));
  EXPECT_TRUE(CanAdminister(kAdmin));
  EXPECT_FALSE(CanAdminister(kInstructor));
  EXPECT_FALSE(CanListCohorts(kOwner));
}

TEST(AccessTest, StudentNeverReleasesNorMakesReferences) {
  EXPECT_FALSE(CanReleaseAttempt(kOwner, AttemptOfOwner(), true));
  EXPECT_FALSE(CanMarkReference(kOwner, AttemptOfOwner(), true));
  EXPECT_FALSE(CanRecordReference(kOwner));
}

TEST(AccessTest, DisabledPersonMayNothing) {
  for (Person person : {kOwner, kInstructor, kAdmin}) {
    person.disabled = true;
    EXPECT_FALSE(CanSeeAttempt(person, AttemptOfOwner(true), true));
    EXPECT_FALSE(CanSeeScore(person, AttemptOfOwner(true), false, true));
    EXPECT_FALSE(CanListCohorts(person));
    EXPECT_FALSE(CanAdminister(person));
  }
}

TEST(AccessTest, RoleNamesReadBack) {
  for (Role role : {Role::kStudent, Role::kInstructor, Role::kAdmin}) {
    EXPECT_EQ(RoleFromName(RoleName(role)), role);
  }
  EXPECT_FALSE(RoleFromName("Admin").has_value());
}

}  // namespace
}  // namespace enamel::server
