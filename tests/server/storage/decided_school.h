#pragma once

#include "tests/server/storage/verified_school.h"

namespace enamel::server::testing {

// A school in which people have decided something of every kind.
class DecidedSchoolTest : public VerifyTest {
 protected:
  DecidedSchoolTest() {
    Store& store = *school_.store;
    teacher_ = AddPerson(store, "teacher", Role::kInstructor);
    const Actor by{teacher_, "page"};
    other_ = *store.exercises.PublishExercise(school_.world.Exercise("other", "v1 of another"),
                                              Uuid{}, by);
    AssignmentRow work;
    work.exercise = "exercise";
    work.due_ms = 9'000'000'000'000;
    work.attempt_limit = 3;
    work.stations = {school_.world.station};
    assignment_ = store.assignments.AddAssignment(work, by)->id;
    EXPECT_TRUE(store.devices.ListDevice("hid:1209:0001:A7", "chair 3", by).ok());
    EXPECT_TRUE(store.settings.PutSetting({"language", "lab2-*", "de", true, 0}, by).ok());
    for (const char* text : {"too deep", "the wall leans"}) {
      SavedText saved;
      saved.text = text;
      EXPECT_TRUE(store.saved_texts.AddSavedText(saved, by).ok());
    }
    RubricRow rubric{school_.world.exercise.id, 2, PutText(store, "rubric 2"), "too strict", 0};
    EXPECT_TRUE(store.rubrics.PublishRubric(rubric, by).ok());
    graded_ = school_.Record(1);
    school_.Score(graded_, scored_);
    reference_ = store.references.AddReference(scored_, "Dr. Example", true, by)->id;
    EXPECT_TRUE(store.judging.ReleaseAttempt(graded_, by, {}).ok());
    EXPECT_TRUE(
        store.judging.OverrideScore(graded_, ScoreOverride{70, "too deep", {}, 0}, by, {}).ok());
    EXPECT_TRUE(store.judging.FlagAttempt(graded_, kExcused, "was ill", by, {}).ok());
    EXPECT_TRUE(
        store.appeals.FileAppeal(graded_, "please look again", Actor{student(), "page"}).ok());
    EXPECT_TRUE(store.appeals.AnswerAppeal(graded_, false, "no", by).ok());
    AnnotationRow remark;
    remark.attempt = graded_;
    remark.text = "see the wall";
    remark_ = store.remarks.AddAnnotation(remark, by)->id;
  }
  Uuid student() const { return school_.world.student; }

  void ExpectWhole(const char* when) {
    for (const Finding& finding : Look().findings) {
      ADD_FAILURE() << when << ": " << finding.kind << " " << finding.object << ": expected "
                    << finding.expected << ", found " << finding.found;
    }
  }

  // What keeps the trail from being edited by accident; whoever edits it on purpose begins here.
  const std::string without_triggers_ =
      "DROP TRIGGER IF EXISTS audit_is_not_changed; DROP TRIGGER IF EXISTS audit_is_not_deleted; "
      "DROP TRIGGER IF EXISTS audit_heads_only_advance; "
      "DROP TRIGGER IF EXISTS audit_heads_are_not_deleted; ";
  Uuid teacher_, graded_, assignment_, reference_, remark_;
  ExerciseRow other_;
};

}  // namespace enamel::server::testing
