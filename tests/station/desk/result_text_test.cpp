#include <gtest/gtest.h>

#include <cctype>

#include "station/desk/exercise_words.h"
#include "station/desk/pages.h"
#include "station/words/score_words.h"
#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

scoring::Mistake Mistake(scoring::MistakeKind kind, double points) {
  scoring::Mistake out;
  out.kind = kind;
  out.place = "wall_distal";
  out.size = 0.32;
  out.points = points;
  return out;
}

scoring::Deduction Place(uint32_t mistake, double volume_mm3, uint32_t stroke) {
  scoring::Deduction d;
  d.mistake = mistake;
  d.volume_m3 = volume_mm3 * 1e-9;
  d.left = stroke == 0;
  if (stroke > 0) d.strokes = {{stroke, 72'000, 72.4, 2, d.volume_m3}};
  return d;
}

TEST(ResultTextTest, MistakesComeWithTheirPlacesAndSmallOnesOnlyInTheSum) {
  using enum scoring::MistakeKind;
  scoring::ScoreResult score;
  score.mistakes = {Mistake(kOverExtended, 7), Mistake(kPit, 3), Mistake(kDeep, 1),
                    Mistake(kSlopes, 0.4)};
  score.deductions = {Place(0, 3, 0), Place(0, 1, 14), Place(1, 2, 0)};
  const std::vector<Loss> losses = LossesOf(score);
  ASSERT_EQ(losses.size(), 3u);
  EXPECT_EQ(losses[0].mistake, &score.mistakes[0]);
  EXPECT_EQ(losses[0].place, &score.deductions[1]) << "one that a stroke can be shown of";
  EXPECT_EQ(losses[2].place, nullptr);
  EXPECT_EQ(StrokeText(kEnglish, *losses[0].place), "Stroke 14, at 1:12");
  EXPECT_EQ(StrokeText(kEnglish, *losses[1].place), "");
  EXPECT_EQ(PlaceOfLossText(kEnglish, *losses[1].place),
            "Too much was left at the place in the ring.");
  EXPECT_EQ(PlaceOfLossText(kEnglish, *losses[0].place),
            "Stroke 14, at 1:12. The ring marks the place.");
}

TEST(ResultTextTest, HowManyMistakesWereMadeIsSaidFirst) {
  using enum scoring::MistakeKind;
  scoring::ScoreResult score;
  EXPECT_EQ(CountText(kEnglish, score), "No mistake cost points");
  score.mistakes = {Mistake(kPit, 0.3)};
  EXPECT_EQ(CountText(kEnglish, score), "Only small mistakes, each below half a point");
  score.mistakes = {Mistake(kPit, 3), Mistake(kDeep, 0.3)};
  EXPECT_EQ(CountText(kEnglish, score), "You made one mistake");
  score.mistakes[1].points = 0.5;
  EXPECT_EQ(CountText(kEnglish, score), "You made 2 mistakes");
}

TEST(ResultTextTest, PointsLostHaveASignAndNothingHasNone) {
  EXPECT_EQ(LostText(kEnglish, 4.26), "\u22124.3");
  EXPECT_EQ(LostText(kEnglish, 12), "\u221212");
  EXPECT_EQ(LostText(kEnglish, 0.04), "0");
}

TEST(ResultTextTest, AStrokeIsShownFromBeforeItUntilAfterItAndALongOneAroundItsHalf) {
  scoring::Deduction place = Place(0, 1, 14);
  EXPECT_EQ(TicksToShow(place, 1000), (ShownTicks{70'500, 74'500}));
  place.strokes[0].first_tick = 300;
  EXPECT_EQ(TicksToShow(place, 1000), (ShownTicks{0, 2800}));
  place.strokes[0].first_tick = 72'000;
  place.strokes[0].lasts_s = 60;
  place.half_tick = 90'000;
  EXPECT_EQ(TicksToShow(place, 1000), (ShownTicks{86'000, 94'000}));
  place.half_tick = 10;  // another stroke's
  EXPECT_EQ(TicksToShow(place, 1000), (ShownTicks{70'500, 78'500}));
  EXPECT_EQ(TicksToShow(Place(0, 1, 0), 1000), (ShownTicks{}));
}

TEST(ResultTextTest, BelowItsTitleAMeasuredValueIsCalledSo) {
  scoring::CriterionResult c;
  c.name = "force_sent_p95_n";
  c.title = "Light hand";
  c.unit = "N";
  c.reasons = {{"at_most", {7.62, 4, 8}, {}}};
  EXPECT_EQ(DetailText(kEnglish, c),
            "Measured: 7.62 N (full marks up to 4.00 N, none from 8.00 N).");
}

TEST(ResultTextTest, AFaultIsSaidAtTheChairAsInTheLog) {
  for (Fault each : {Fault::kStalled, Fault::kLateOnce, Fault::kLateOften, Fault::kUnplugged,
                     Fault::kSwitchedOff}) {
    // There it begins a sentence.
    std::string said = kEnglish.Say(FaultKey(each));
    said[0] = static_cast<char>(std::tolower(said[0]));
    EXPECT_EQ(said, FaultText(each));
  }
  EXPECT_STREQ(FaultKey(Fault::kNone), "");
}

TEST(ResultTextTest, AnAssignmentSaysWhenItIsDueAndHowManyAttemptsAreLeft) {
  constexpr int64_t kMinute = 60'000, kNow = 1'000'000 * kMinute;
  ASSERT_EQ(setenv("TZ", "UTC", 1), 0);
  tzset();
  Catalogue::Exercise e;
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow), "any number of attempts");
  e.due_unix_ms = kNow + 3 * 24 * 60 * kMinute + kMinute;
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow), "due 1971-11-29 10:41, in 3 days");
  e.due_unix_ms = kNow + 47 * 60 * kMinute;
  e.attempt_limit = 5;
  e.attempts_left = 1;
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow), "due 1971-11-28 09:40, in 47 hours, 1 attempt left");
  e.due_unix_ms = kNow + 40 * kMinute;
  e.attempts_left = 2;
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow),
            "due 1971-11-26 11:20, in 40 minutes, 2 attempts left");
  e.due_unix_ms = kNow - 2 * kMinute;
  e.attempt_limit = 0;
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow), "past due: counts as late");
}

TEST(ResultTextTest, WhatCannotBeBegunSaysWhyInTheReadersLanguage) {
  constexpr int64_t kMinute = 60'000, kNow = 1'000'000 * kMinute;
  ASSERT_EQ(setenv("TZ", "UTC", 1), 0);
  tzset();
  const Words german(language::Language::kGerman);
  Catalogue::Exercise e;
  EXPECT_EQ(RefusalText(german, e), "");
  auto refuse = [&](const char* field) {
    e.refusal = Status(Code::kForbidden, "go to chair 4", field);
  };
  refuse("stations");
  e.stations = "Chair 4";
  EXPECT_EQ(RefusalText(german, e),
            "Diese Prüfung findet an einer anderen Station statt: Chair 4. Gehen Sie dorthin.");
  refuse("attempt_limit");
  e.attempt_limit = 3;
  EXPECT_EQ(RefusalText(kEnglish, e),
            "all 3 attempts are used: your instructor can excuse one, so that it does not count");
  EXPECT_EQ(RefusalText(german, e).find("alle 3 Versuche"), 0u);
  refuse("due");
  e.due_unix_ms = kNow - kMinute;
  EXPECT_EQ(RefusalText(kEnglish, e),
            "was due 1971-11-26 10:39: ask your instructor for more time");
  refuse("opens");
  e.opens_unix_ms = kNow + kMinute;
  EXPECT_EQ(RefusalText(kEnglish, e), "opens 1971-11-26 10:41: come back then");
  EXPECT_EQ(AssignmentText(kEnglish, e, kNow), RefusalText(kEnglish, e));
  refuse("of_tomorrow");
  EXPECT_EQ(RefusalText(german, e).find("chair"), std::string::npos) << RefusalText(german, e);
}

TEST(ResultTextTest, ADeviceIsNamedAsPeopleCallIt) {
  const Words german(language::Language::kGerman);
  const std::vector<Catalogue::Profile> listed = {{"omega3", "Our Omega", {}},
                                                  {"pointer", "Mouse, no force", {}}};
  EXPECT_EQ(DeviceText(german, "omega3", listed), "Our Omega");
  EXPECT_EQ(DeviceText(german, "pointer", listed), "Maus oder 3D-Maus, ohne Kraft");
  EXPECT_EQ(DeviceText(german, "phantom_desktop", {}), "Phantom Desktop") << "without the server";
  EXPECT_EQ(DeviceText(german, "chair_7", {}), "chair_7");
}

TEST(ResultTextTest, ExercisesOfOneTitleAreToldApart) {
  Catalogue::Exercise e;
  e.title = "Crown preparation";
  EXPECT_EQ(CardOf(kEnglish, e, 0).lines, (std::vector<std::string>{"any number of attempts"}))
      << "without its documents";
  e.facts = Catalogue::Facts{46, "crown_top", false, false, true};
  e.attempt_limit = 3;
  e.attempts_left = 2;
  e.best_score = 86.6;
  EXPECT_EQ(CardOf(kEnglish, e, 0).lines,
            (std::vector<std::string>{"Tooth 46, whole crown", "Graded: 2 attempts left",
                                      "Best score: 87 of 100"}));
  e.last_remark = "too steep";
  EXPECT_EQ(CardOf(kEnglish, e, 0).lines.back(), "Last remark: too steep");
  e.facts = Catalogue::Facts{46, "crown_top", true, true, false};
  EXPECT_EQ(CardOf(kEnglish, e, 0).lines[0],
            "Tooth 46, whole crown, with caries, between neighbours");
  EXPECT_EQ(CardOf(kEnglish, e, 0).lines[1], "Practice: 2 attempts left");
  e.facts = Catalogue::Facts{0, "circle", false, false, false};
  EXPECT_EQ(PlaceText(kEnglish, e), "") << "the practice block";
  e.exam = true;
  EXPECT_EQ(CardOf(kEnglish, e, 0).right, "EXAM");
}

TEST(ResultTextTest, WhatWasCutOffOrReservedSaysHowLongAgoAndHowLongStill) {
  constexpr int64_t kMinute = 60'000, kNow = 1'000'000 * kMinute;
  SpooledAttempt cut;
  cut.chunks = 12;
  cut.created_unix_ms = kNow - 3 * 60 * kMinute;
  EXPECT_EQ(CutOffText(kEnglish, cut, "Omega 3DOF", kNow), "Begun 3 hours ago; device: Omega 3DOF");
  cut.created_unix_ms = kNow + kMinute;  // the clock was set back
  EXPECT_EQ(CutOffText(kEnglish, cut, "Omega 3DOF", kNow),
            "Begun less than a minute ago; device: Omega 3DOF");
  EXPECT_EQ(HandedInText(kEnglish, cut, "Omega 3DOF", kNow),
            "Not all of it is on the server yet; made less than a minute ago; device: Omega 3DOF");
  cut.seal.emplace();
  cut.sealed_at_server = true;
  EXPECT_EQ(HandedInText(kEnglish, cut, "Omega 3DOF", kNow),
            "Handed in; made less than a minute ago; device: Omega 3DOF");
  ReservedAttempt reserved;
  reserved.ticket.person = "Ada";
  reserved.ticket.expires_unix_ms = kNow + kMinute;
  EXPECT_EQ(ReservedText(kEnglish, reserved, "Omega 3DOF", kNow),
            "Ada, 1 minute left; device: Omega 3DOF");
}

TEST(ResultTextTest, ABurIsToldInMillimetres) {
  EXPECT_EQ(BurText(kEnglish, {cutting::BurShape::kCylinder, 0.5e-3, 4e-3}),
            "Cylinder, 1.0 mm across, 4.0 mm long");
  EXPECT_EQ(BurText(kEnglish, {cutting::BurShape::kInvertedCone, 0.7e-3, 1.4e-3, 0.5e-3}),
            "Inverted cone, 1.4 mm across, 1.4 mm long");
  EXPECT_EQ(BurText(kEnglish, {cutting::BurShape::kSphere, 0.6e-3}),
            "Round, 1.2 mm across, 1.2 mm long");
}

TEST(ResultTextTest, AnExamNeverPromisesAScoreAtOnce) {
  scene::Exercise exercise;
  exercise.graded = false;
  EXPECT_EQ(FactsText(kEnglish, exercise, "Block", false),
            "Block. Practice: you see the score at once.");
  const std::string held = "Block. Graded: you see the score after your instructor releases it.";
  EXPECT_EQ(FactsText(kEnglish, exercise, "Block", true), held);
  exercise.graded = true;
  EXPECT_EQ(FactsText(kEnglish, exercise, "Block", false), held);
}

TEST(ProgressTest, IsShownInPracticeAndToInstructorsButNeverInAnExam) {
  for (bool graded : {false, true}) {
    for (bool instructor : {false, true}) {
      EXPECT_FALSE(MayShowProgress(graded, true, instructor));
      EXPECT_EQ(MayShowProgress(graded, false, instructor), !graded || instructor);
    }
  }
}

TEST(OutlineTest, IsShownToStudentsAsTheServerSaysAndToInstructorsExceptInExams) {
  for (bool exam : {false, true}) {
    for (bool instructor : {false, true}) {
      EXPECT_TRUE(MayShowOutline(true, exam, instructor));
      EXPECT_EQ(MayShowOutline(false, exam, instructor), instructor && !exam);
    }
  }
}

}  // namespace
}  // namespace enamel::station::desk
