#include "common/scoring/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace enamel::scoring {
namespace {

using scene::Rubric;
using scene::RubricCriterion;

// Prices whose bounds are far away, so that a measure of one size costs the points but for a millionth.
constexpr double kFar = 1e4;
Rubric ClassOne() {
  Rubric r;
  r.name = "class-1";
  r.version = 3;
  r.prices = {{"floor", 0.4, 0.5, 10, kFar, 2, 10, "a test"},
              {"wall", 0.5, 1, 12, kFar, 3, 12, "a test"},
              {"elsewhere", 1, 0, 20, kFar, 2, 12, "a test"},
              {"caries", 0, 100, 100, kFar, 6, 24, "a test"}};
  r.criteria = {
      {"force_sent_p95_n", "Light hand", "N", 10, {{4, 1}, {8, 0}}, "Let the bur cut.", {}},
      {"time_s", "Time", "s", 8, {{100, 1}, {300, 0}}, "", {}}};
  return r;
}

struct Sizes {
  double floor_over = 0, mesial_over = 0, mesial_left = 0, distal_left = 0, elsewhere = 0,
         caries = 0;
};
std::vector<RegionMeasure> Measures(const Sizes& s) {
  return {{"floor", "floor", s.floor_over, 0},
          {"wall_mesial", "wall", s.mesial_over, s.mesial_left},
          {"wall_distal", "wall", 0, s.distal_left},
          {"elsewhere", "elsewhere", s.elsewhere, 0},
          {"caries", "caries", 0, s.caries}};
}

MetricSet Hand(double force_n, double seconds) {
  return {{{"force_sent_p95_n", force_n, "N"}, {"time_s", seconds, "s"}}, {}};
}

ScoreResult Score(const Rubric& rubric, const MetricSet& metrics, const Sizes& sizes,
                  std::vector<Mistake> mistakes = {}) {
  auto result = ApplyRubric(rubric, metrics, Measures(sizes), std::move(mistakes));
  EXPECT_TRUE(result.ok()) << result.status().message();
  return result.ok() ? *result : ScoreResult{};
}
ScoreResult Score(const Sizes& sizes) { return Score(ClassOne(), Hand(1, 50), sizes); }
ScoreResult ScoreOfHand(double force_n, double seconds) {
  return Score(ClassOne(), Hand(force_n, seconds), {});
}

// Of points * M / sqrt(1 + (M * points / most)^2), where `most` is kFar.
constexpr double kNearlyAll = 1e-4;

TEST(ScoreTest, ACutAsAskedForByALightHandInTimeIsAHundred) {
  const ScoreResult r = Score({});
  EXPECT_EQ(r.score, 100);
  EXPECT_EQ(r.beyond, 0);
  EXPECT_EQ(r.acceptance, Acceptance::kAcceptable);
  EXPECT_FALSE(r.critical_fail);
  EXPECT_EQ(r.rubric_version, 3);
  EXPECT_EQ(BrokenLaw(r), "");
}

TEST(ScoreTest, ARegionPaysItsDearerSideOnce) {
  const ScoreResult r = Score({.mesial_over = 0.5, .mesial_left = 2});
  ASSERT_EQ(r.costs.size(), 5U);
  EXPECT_NEAR(r.costs[1].lost, 24, kNearlyAll);
  EXPECT_FALSE(r.costs[1].over);
  EXPECT_NEAR(r.score, 76, kNearlyAll);
  const ScoreResult over = Score({.mesial_over = 0.5, .mesial_left = 0.9});
  EXPECT_NEAR(over.costs[1].lost, 12, kNearlyAll);
  EXPECT_TRUE(over.costs[1].over);
  EXPECT_NEAR(over.score, 88, kNearlyAll);
}

TEST(ScoreTest, IsAHundredLessWhatEveryPartCosts) {
  const ScoreResult r = Score(
      ClassOne(), Hand(6, 200),
      {.floor_over = 0.2, .mesial_over = 0.25, .distal_left = 0.5, .elsewhere = 0.1, .caries = 3});
  // 5 + 6 + 6 + 2 + 3, and half of 10 and of 8.
  EXPECT_NEAR(r.score, 100 - 22 - 9, kNearlyAll);
  double criteria = 0, regions = 0;
  for (const CriterionResult& c : r.criteria) criteria += c.lost;
  for (const RegionCost& c : r.costs) regions += c.lost;
  EXPECT_NEAR(criteria, 100 - r.score, 1e-12);
  EXPECT_NEAR(regions, criteria - 9, 1e-12);
}

TEST(ScoreTest, GroupsStandInTheirOrderBeforeTheHandWithWhatTheirRegionsCost) {
  const ScoreResult r = Score({.floor_over = 0.2,
                               .mesial_over = 0.25,
                               .distal_left = 0.75,
                               .elsewhere = 0.09,
                               .caries = 3});
  ASSERT_EQ(r.criteria.size(), 5U);
  const struct {
    const char *name, *title;
    double lost;
    State state;
  } expected[] = {{"outline", "Outline", 6 + 9, State::kModify},
                  {"internal_form", "Internal form", 5 + 3, State::kModify},
                  {"tissue_preserved", "Tissue preserved", 1.8, State::kAcceptable}};
  for (size_t i = 0; i < 3; ++i) {
    const CriterionResult& c = r.criteria[i];
    EXPECT_EQ(c.name, expected[i].name);
    EXPECT_EQ(c.title, expected[i].title);
    EXPECT_NEAR(c.lost, expected[i].lost, 2 * kNearlyAll) << c.name;
    EXPECT_EQ(c.state, expected[i].state) << c.name;
    EXPECT_NEAR(c.most, 100.0 / 3, 1e-12) << "three groups have prices, margins have none";
  }
  EXPECT_EQ(r.criteria[3].name, "force_sent_p95_n");
  EXPECT_EQ(r.criteria[4].name, "time_s");
  EXPECT_EQ(r.criteria[4].group, Group::kHand);
}

TEST(ScoreTest, IsNeverBelowZeroAndTellsHowFarItWouldBe) {
  const ScoreResult r = Score({.elsewhere = 7});
  EXPECT_EQ(r.score, 0);
  EXPECT_EQ(r.points, 0);
  // 140 points by a price with a bound.
  EXPECT_NEAR(r.beyond, 140 / std::sqrt(1 + 0.014 * 0.014) - 100, 1e-9);
  EXPECT_EQ(Score({.elsewhere = 4}).beyond, 0);
}

TEST(ScoreTest, ACriticalErrorScoresZeroAndShowsThePointsWithoutIt) {
  Rubric rubric = ClassOne();
  rubric.critical = {{"pulp_exposed", "pulp_exposed_mm2", "mm2", 0.1, true, "a test"}};
  MetricSet metrics = Hand(1, 50);
  metrics.values.push_back({"pulp_exposed_mm2", 0.1, "mm2"});
  EXPECT_EQ(Score(rubric, metrics, {}).score, 100);
  metrics.values.back().value = 0.11;
  const ScoreResult r = Score(rubric, metrics, {.mesial_over = 0.25});
  EXPECT_TRUE(r.critical_fail);
  EXPECT_EQ(r.score, 0);
  EXPECT_NEAR(r.points, 94, kNearlyAll);
  EXPECT_EQ(r.acceptance, Acceptance::kNotAcceptable);
  EXPECT_EQ(BrokenLaw(Score(rubric, metrics, {})), "");
}

TEST(ScoreTest, AcceptanceIsThatOfTheWorstRegionAndOfThePoints) {
  const auto acceptance = [](const Sizes& s) { return Score(s).acceptance; };
  // Walls: modify from 3 points, redo from 12.
  EXPECT_EQ(acceptance({.mesial_over = 0.12}), Acceptance::kAcceptable);
  EXPECT_EQ(acceptance({.mesial_over = 0.13}), Acceptance::kWithRemarks);
  EXPECT_EQ(acceptance({.mesial_over = 0.49}), Acceptance::kWithRemarks);
  EXPECT_EQ(acceptance({.mesial_over = 0.51}), Acceptance::kNotAcceptable);
  // Each costs less than what is to be done anew, and together they are still under half.
  Rubric patient = ClassOne();
  for (auto& price : patient.prices) price.redo_points = 99;
  const auto whole = [&](double caries) {
    return Score(patient, Hand(1, 50), {.caries = caries}).acceptance;
  };
  EXPECT_EQ(whole(49.9), Acceptance::kWithRemarks);
  EXPECT_EQ(whole(50.1), Acceptance::kNotAcceptable);
  // The hand's points count for the sum, and a heavy hand is no region to be changed.
  Rubric heavy = ClassOne();
  heavy.criteria[0].points = 49;
  EXPECT_EQ(Score(heavy, Hand(9, 50), {}).acceptance, Acceptance::kAcceptable);
  heavy.criteria[0].points = 51;
  EXPECT_EQ(Score(heavy, Hand(9, 50), {}).acceptance, Acceptance::kNotAcceptable);
}

TEST(HandTest, LosesLinearlyBetweenTheMapsPointsAndConstantlyBeyond) {
  EXPECT_EQ(ScoreOfHand(3, 50).criteria[3].lost, 0);
  EXPECT_EQ(ScoreOfHand(4, 50).criteria[3].lost, 0);
  EXPECT_NEAR(ScoreOfHand(5, 50).criteria[3].lost, 2.5, 1e-12);
  EXPECT_NEAR(ScoreOfHand(7, 50).criteria[3].lost, 7.5, 1e-12);
  EXPECT_EQ(ScoreOfHand(80, 50).criteria[3].lost, 10);
  EXPECT_NEAR(ScoreOfHand(5, 250).score, 100 - 2.5 - 6, 1e-12);
  EXPECT_EQ(ScoreOfHand(5, 250).criteria[3].most, 10);
}

TEST(HandTest, ASentenceTellsWhatWasFoundWhatWasAskedForAndWhatToDo) {
  EXPECT_EQ(ScoreOfHand(3, 50).criteria[3].reason, "Light hand: 3.00 N (full marks up to 4.00 N).");
  EXPECT_EQ(ScoreOfHand(6, 50).criteria[3].reason,
            "Light hand: 6.00 N (full marks up to 4.00 N, none from 8.00 N). Press less and let "
            "the bur cut. Let the bur cut.");
  EXPECT_EQ(ScoreOfHand(1, 180).criteria[4].reason,
            "Time: 180.0 s (full marks up to 100.0 s, none from 300.0 s).");
}

TEST(HandTest, ASmallLossGetsNeitherAdviceNorAComment) {
  // 0.4 of 10 points, and 1 of 10.
  EXPECT_EQ(ScoreOfHand(4.16, 50).criteria[3].reasons.size(), 1U);
  EXPECT_EQ(ScoreOfHand(4.16, 50).criteria[3].state, State::kAcceptable);
  const CriterionResult told = ScoreOfHand(4.4, 50).criteria[3];
  EXPECT_EQ(told.reasons.back().code, "do_lighter");
  EXPECT_EQ(told.state, State::kModify);
  EXPECT_TRUE(told.comment.empty()) << "1 of 10 points is no fault to be described";
  EXPECT_EQ(ScoreOfHand(5.01, 50).criteria[3].comment, "Let the bur cut.");
}

// "0.03 N (full marks up to 0.03 N)" with points lost is a riddle.
TEST(HandTest, LimitsAreShownAsTheyAreAndWhatMissesThemDoesNotReadLikeThem) {
  auto reason = [](double limit, double value) {
    Rubric rubric = ClassOne();
    rubric.criteria = {{"dtw_force_n", "As shown", "N", 10, {{limit, 1}, {0.1, 0}}, "", {}}};
    return Score(rubric, {{{"dtw_force_n", value, "N"}}, {}}, {}).criteria.back().reason;
  };
  EXPECT_EQ(reason(0.025, 0.031), "As shown: 0.03 N (full marks up to 0.025 N, none from 0.10 N).");
  EXPECT_EQ(reason(0.05, 0.0504),
            "As shown: 0.0504 N (full marks up to 0.05 N, none from 0.10 N).");
  EXPECT_EQ(reason(0.05, 0.0998), "As shown: 0.10 N (full marks up to 0.05 N, none from 0.10 N).");
  EXPECT_EQ(reason(0.0285, 0.028), "As shown: 0.028 N (full marks up to 0.0285 N).");
}

TEST(HandTest, BeyondALimitThatFailsTheScoreIsZero) {
  Rubric rubric = ClassOne();
  rubric.criteria[0].fails_above = 9;
  EXPECT_FALSE(Score(rubric, Hand(9, 50), {}).critical_fail);
  const ScoreResult r = Score(rubric, Hand(9.5, 50), {});
  EXPECT_TRUE(r.critical_fail);
  EXPECT_EQ(r.score, 0);
  EXPECT_EQ(r.points, 90);
  EXPECT_NE(r.criteria[3].reason.find("fails the whole attempt"), std::string::npos);
}

TEST(HandTest, WhatHasNoValueCostsNothing) {
  for (const auto& [why, code] :
       {std::pair{NoValue::kNotInTask, "not_in_task"}, std::pair{NoValue::kNotMade, "not_made"}}) {
    MetricSet metrics = Hand(1, 50);
    metrics.values.pop_back();
    metrics.missing = {{"time_s", why}};
    const ScoreResult r = Score(ClassOne(), metrics, {});
    EXPECT_EQ(r.score, 100);
    EXPECT_FALSE(r.criteria.back().judged);
    ASSERT_EQ(r.criteria.back().reasons.size(), 1U);
    EXPECT_EQ(r.criteria.back().reasons[0].code, code);
  }
}

TEST(HandTest, AMetricThatWasNotMeasuredOrIsNotFiniteIsRefusedByName) {
  MetricSet metrics = Hand(1, 50);
  metrics.values.pop_back();
  EXPECT_EQ(ApplyRubric(ClassOne(), metrics, Measures({})).status().field(), "time_s");
  metrics.missing = {{"time_s", NoValue::kNotUsed}};
  EXPECT_EQ(ApplyRubric(ClassOne(), metrics, Measures({})).status().field(), "time_s");
  EXPECT_EQ(ApplyRubric(ClassOne(), Hand(1.0 / 0.0, 50), Measures({})).status().field(),
            "force_sent_p95_n");
}

MetricSet AtLimit(double force_n) {
  MetricSet metrics = Hand(force_n, 50);
  metrics.values[0].limited = true;
  return metrics;
}

// A device that cannot press back as hard as the hand presses says nothing of how light it is.
TEST(HandTest, AForceAtTheDevicesLimitCostsNothing) {
  for (const double force : {2.0, 6.0}) {
    const CriterionResult c = Score(ClassOne(), AtLimit(force), {}).criteria[3];
    EXPECT_FALSE(c.judged);
    EXPECT_EQ(c.lost, 0);
    EXPECT_EQ(c.value, force);
    EXPECT_NE(c.reason.find("at its limit"), std::string::npos) << c.reason;
  }
}

// Or pressing as hard as one can would be a way out.
TEST(HandTest, AForceThatCostsAllAtLeastStaysJudgedAtTheLimit) {
  EXPECT_TRUE(Score(ClassOne(), AtLimit(8.5), {}).criteria[3].judged);
  EXPECT_EQ(Score(ClassOne(), AtLimit(8.5), {}).score, 90);
  Rubric critical = ClassOne();
  critical.criteria[0].fails_above = 7;
  EXPECT_TRUE(Score(critical, AtLimit(7.5), {}).critical_fail);
  EXPECT_FALSE(Score(critical, AtLimit(6.5), {}).critical_fail);
  EXPECT_FALSE(Score(critical, AtLimit(6.5), {}).criteria[3].judged);
}

TEST(SentenceTest, ACodeThatIsNotKnownIsLeftOut) {
  const MetricInfo& time = *FindMetric("time_s");
  EXPECT_EQ(Sentence("Time", time, {{"any", {4}, {"s"}}, {"of_tomorrow", {1}, {"s"}}}, "Oh."),
            "Time: 4.0 s. Oh.");
  EXPECT_EQ(Sentence("Time", time, {{"within", {}, {}}}, ""), "Time:") << "too few values";
}

TEST(SentenceTest, ASignedFigureNamesItsSideAndAThinWallTheGrid) {
  const MetricInfo &wall = *FindMetric("wall_mesial_mm"),
                   &cover = *FindMetric("remaining_dentin_mm");
  const std::vector<scene::RubricPoint> within = {{-0.3, 0}, {-0.05, 1}, {0.05, 1}, {0.3, 0}};
  EXPECT_EQ(Sentence("Wall", wall, {FoundReason(wall, -0.2, within)}, ""),
            "Wall: 0.20 mm short (full marks within 0.05 mm, none beyond 0.30 mm).");
  EXPECT_EQ(Sentence("Wall", wall, {FoundReason(wall, 0, within)}, ""),
            "Wall: 0.00 mm off (full marks within 0.05 mm).");
  EXPECT_EQ(Sentence("Cover", cover, {{"any", {0.12}, {"mm"}}, BelowGridReason(cover, 0.2)}, ""),
            "Cover: 0.12 mm. Thinner than 0.20 mm: the grid cannot measure it more exactly.");
}

TEST(FullMarksTest, AHundredIsSharedEvenlyByTheGroupsThatHaveAPrice) {
  EXPECT_EQ(GroupsOf(ClassOne()),
            (std::vector<Group>{Group::kOutline, Group::kInternalForm, Group::kTissuePreserved}));
  EXPECT_NEAR(FullMarksOf(ClassOne()), 100.0 / 3, 1e-12);
  Rubric stump = ClassOne();
  stump.prices.push_back({"margin", 0.3, 0.4, 4, 12, 1, 4, "a test"});
  EXPECT_EQ(FullMarksOf(stump), 25);
}

TEST(ValidateRubricTest, RefusesWhatCannotBeScoredAndNamesIt) {
  struct Case {
    const char* field;
    std::function<void(Rubric&)> spoil;
  };
  const Case cases[] = {
      {"prices", [](Rubric& r) { r.prices.clear(); }},
      {"prices[1].of", [](Rubric& r) { r.prices[1].of = "beauty"; }},
      {"criteria[0].metric", [](Rubric& r) { r.criteria[0].metric = "beauty"; }},
      {"criteria[0].metric",
       [](Rubric& r) {
         r.criteria[0].metric = "wall_mesial_mm";
         r.criteria[0].unit = "mm";
       }},
      {"criteria[1].metric",
       [](Rubric& r) {
         r.criteria[1].metric = "damage_percent";
         r.criteria[1].unit = "%";
       }},
      {"criteria[1].unit", [](Rubric& r) { r.criteria[1].unit = "mm"; }},
      {"criteria[0].map", [](Rubric& r) { r.criteria[0].map.clear(); }},
      {"criteria[0].map", [](Rubric& r) { std::swap(r.criteria[0].map[0], r.criteria[0].map[1]); }},
      {"criteria[0].map", [](Rubric& r) { r.criteria[0].map[1].share = 1.5; }},
      {"criteria[0].map", [](Rubric& r) { r.criteria[0].map[1].share = 0.0 / 0.0; }},
      {"criteria[1].points", [](Rubric& r) { r.criteria[1].points = -1; }},
      {"criteria[1].fails_above", [](Rubric& r) { r.criteria[1].fails_above = 0.0 / 0.0; }},
      {"criteria",
       [](Rubric& r) {
         const RubricCriterion one = r.criteria[0];
         r.criteria.resize(kMaxCriteria, one);
       }},
      {"critical[0].error",
       [](Rubric& r) {
         r.critical = {{"ugly", "time_s", "s", 1, true, "x"}};
       }},
      {"critical[0].unit",
       [](Rubric& r) {
         r.critical = {{"all_cut", "time_s", "mm", 1, true, "x"}};
       }},
      {"critical", [](Rubric& r) { r.critical.resize(kMaxCritical + 1); }},
  };
  for (const Case& c : cases) {
    Rubric rubric = ClassOne();
    c.spoil(rubric);
    const Status status = ValidateRubric(rubric);
    EXPECT_EQ(status.code(), Code::kInvalidInput) << c.field;
    EXPECT_EQ(status.field(), c.field) << status.message();
    EXPECT_FALSE(ApplyRubric(rubric, Hand(1, 50), Measures({})).ok());
  }
  EXPECT_TRUE(ValidateRubric(ClassOne()).ok());
  Rubric handless = ClassOne();
  handless.criteria.clear();
  EXPECT_TRUE(ValidateRubric(handless).ok());
}

// A score with mistakes that explain it, and everything else that it can hold.
ScoreResult Filled() {
  Rubric rubric = ClassOne();
  rubric.critical = {{"contact_left", "wall_mesial_mm", "mm", 1, false, "a textbook"}};
  MetricSet metrics = Hand(5.1 + 0.2, 123.4567890123456789);
  metrics.values.push_back({"wall_mesial_mm", 0.1 + 0.2, "mm"});
  metrics.missing = {{"caries_left_mm3", NoValue::kNotInTask},
                     {"tilt_mesial_deg", NoValue::kNotMade},
                     {"dtw_pose_mm", NoValue::kNotUsed}};
  const Sizes sizes{.floor_over = 0.31, .mesial_left = 0.7, .elsewhere = 0.3};
  const std::vector<RegionCost> costs = Score(sizes).costs;
  Mistake deep{
      MistakeKind::kDeep,  "floor", 0.31, {1e-3, -0.123456789e-3, -2e-3}, {}, costs[0].lost,
      Group::kInternalForm};
  Mistake short_wall{MistakeKind::kUnderExtended,
                     "wall_mesial",
                     0.7,
                     {2e-3, 0, 0},
                     {},
                     costs[1].lost,
                     Group::kOutline};
  Mistake shifted{MistakeKind::kShifted, "", 1.0 / 3, {}, {0.6, -0.8, 0}, costs[3].lost,
                  Group::kOutline};
  ScoreResult r = Score(rubric, metrics, sizes, {short_wall, deep, shifted});
  r.reference_attempt = "01890a5d-ac96-774b-bcce-b302099a8057";
  r.ticks = 123'456'789'012;
  r.gap_ticks = 7;
  r.late_ticks = 8;
  r.bounded_ticks = 9;
  r.outages = 10;
  r.disturbance = {0.25, 1.5, 7.0 / 3};
  r.metrics.front().below_grid = 0.2;
  r.metrics.push_back({"force_sent_max_n", 7.9, "N", true});
  Deduction over;
  over.mistake = 1;
  over.volume_m3 = 1.23456789e-9;
  over.position_m = {1.7e-3, -0.123456789e-3, -1e-3};
  over.facing = {-1, 0, 0};
  over.first_tick = 5'000'000'000;
  over.first_s = 72.125;
  over.stroke_count = 2;
  over.strokes = {{7, 5'000'000'000, 72.125, 2, 1e-9}, {3, 6'000'000'000, 80, 1, 0.23456789e-9}};
  Deduction left;
  left.left = true;
  left.volume_m3 = 0.1e-9;
  r.deductions = {left, over};
  r.witness_note = "tick 12: \"force_sent\"\n";
  return r;
}

TEST(BrokenLawTest, FindsAChangedNumberInCriteriaRegionsAndMistakes) {
  EXPECT_EQ(BrokenLaw(Filled()), "");
  const auto broken = [](const std::function<void(ScoreResult&)>& change) {
    ScoreResult r = Filled();
    change(r);
    return BrokenLaw(r);
  };
  constexpr double kLittle = 1e-6;
  EXPECT_NE(broken([](ScoreResult& r) { r.points += kLittle; }), "");
  EXPECT_NE(broken([](ScoreResult& r) { r.beyond += kLittle; }), "");
  for (size_t i = 0; i < Filled().criteria.size(); ++i)
    EXPECT_NE(broken([&](ScoreResult& r) { r.criteria[i].lost += kLittle; }), "") << i;
  for (size_t i = 0; i < Filled().costs.size(); ++i)
    EXPECT_NE(broken([&](ScoreResult& r) { r.costs[i].lost += kLittle; }), "") << i;
  for (size_t i = 0; i < Filled().mistakes.size(); ++i)
    EXPECT_NE(broken([&](ScoreResult& r) { r.mistakes[i].points -= kLittle; }), "") << i;
  EXPECT_NE(broken([](ScoreResult& r) { r.mistakes.pop_back(); }), "");
  EXPECT_NE(broken([](ScoreResult& r) { r.points = std::nan(""); }), "");
  // A critical error takes the score, and no law.
  EXPECT_EQ(broken([](ScoreResult& r) {
              r.score = 0;
              r.critical_fail = true;
            }),
            "");
}

TEST(BrokenLawTest, HoldsBeyondAHundred) {
  const Sizes sizes{.mesial_left = 3, .elsewhere = 7};
  const ScoreResult r = Score(sizes);
  std::vector<Mistake> mistakes;
  for (const RegionCost& cost : r.costs) mistakes.emplace_back().points = cost.lost;
  EXPECT_EQ(BrokenLaw(Score(ClassOne(), Hand(1, 50), sizes, mistakes)), "");
}

TEST(ScoreJsonTest, ReadsBackToTheSameScore) {
  const ScoreResult filled = Filled();
  auto back = ScoreFromJson(ToJson(filled));
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(ToJson(*back), ToJson(filled));
  EXPECT_EQ(*ScoreFromJson(ToJson(*back)), *back);
  EXPECT_EQ(BrokenLaw(*back), "");
  EXPECT_NEAR(back->score, filled.score, 1e-10);
  ASSERT_EQ(back->criteria.size(), filled.criteria.size());
  EXPECT_EQ(back->criteria[1].group, Group::kInternalForm);
  EXPECT_EQ(back->criteria[3].reason, filled.criteria[3].reason);
  EXPECT_EQ(back->criteria[0].state, filled.criteria[0].state);
  ASSERT_EQ(back->costs.size(), filled.costs.size());
  for (size_t i = 0; i < back->costs.size(); ++i) {
    EXPECT_EQ(back->measures[i].name, filled.measures[i].name);
    EXPECT_EQ(back->costs[i].over, filled.costs[i].over);
    EXPECT_EQ(back->costs[i].state, filled.costs[i].state);
  }
  ASSERT_EQ(back->mistakes.size(), 3U);
  EXPECT_EQ(back->mistakes[0].kind, MistakeKind::kUnderExtended);
  EXPECT_EQ(back->mistakes[0].place, "wall_mesial");
  EXPECT_NEAR(back->mistakes[1].at_m.y, -0.123456789e-3, 1e-15);
  EXPECT_NEAR(back->mistakes[2].towards.y, -0.8, 1e-12);
  EXPECT_EQ(back->ticks, 123'456'789'012U);
  EXPECT_EQ(back->outages, 10U);
  ASSERT_EQ(back->deductions.size(), 2U);
  EXPECT_TRUE(back->deductions[0].left);
  EXPECT_EQ(back->deductions[1].mistake, 1U);
  EXPECT_EQ(back->deductions[1].strokes[1].first_tick, 6'000'000'000U);
  EXPECT_NEAR(back->deductions[1].position_m.y, -0.123456789e-3, 1e-15);
  EXPECT_EQ(back->witness_note, filled.witness_note);
  EXPECT_TRUE(back->disturbance.disturbed());
  EXPECT_TRUE(back->metrics.back().limited);
  EXPECT_FALSE(back->metrics.front().limited);
  EXPECT_EQ(back->metrics.front().below_grid, 0.2);
}

TEST(ScoreJsonTest, ListsReadCriteriaAndMistakesAlone) {
  const ScoreResult filled = Filled();
  auto points = PointsFromJson(ToJson(filled));
  ASSERT_TRUE(points.ok()) << points.status().message();
  EXPECT_EQ(points->criteria, ScoreFromJson(ToJson(filled))->criteria);
  EXPECT_EQ(points->mistakes, ScoreFromJson(ToJson(filled))->mistakes);
  EXPECT_TRUE(points->metrics.empty() && points->costs.empty());
}

TEST(ScoreJsonTest, NumbersOfAnySizeSurviveAnyNumberOfTrips) {
  ScoreResult r = Filled();
  uint64_t bits = 0x3ff123456789abcd;
  for (int i = 0; i < 2000; ++i) {
    bits = bits * 6364136223846793005U + 1442695040888963407U;
    const double number = static_cast<double>(bits >> 11) * std::pow(10, -10 - i % 12);
    r.metrics[0].value = r.mistakes[0].size = r.measures[0].over = r.costs[0].lost = number;
    r.mistakes[1].at_m.x = r.deductions[1].volume_m3 = number;
    const std::string once = ToJson(r);
    auto back = ScoreFromJson(once);
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(ToJson(*back), once);
  }
}

TEST(ScoreJsonTest, EveryTruncationAndEveryMissingMemberIsRefused) {
  const std::string text = ToJson(Filled());
  for (size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(ScoreFromJson(text.substr(0, n)).ok());
  for (const char* member :
       {"score",    "critical_fail", "critical",  "points",         "acceptance",
        "above",    "kind",          "criteria",  "group",          "lost",
        "most",     "state",         "judged",    "reason",         "reasons",
        "comment",  "regions",       "over",      "left",           "dearer",
        "mistakes", "place",         "size",      "at_mm",          "towards",
        "beyond",   "metrics",       "missing",   "deductions",     "mistake",
        "lasts_s",  "here",          "envelope",  "rubric_version", "scoring_version",
        "ticks",    "disturbance",   "witness_ok"}) {
    std::string spoiled = text;
    // As a name, and not as a value.
    const std::string name = "\"" + std::string(member) + "\":";
    ASSERT_NE(spoiled.find(name), std::string::npos) << member;
    spoiled.replace(spoiled.find(name), name.size(), "\"x\":");
    auto result = ScoreFromJson(spoiled);
    ASSERT_FALSE(result.ok()) << member;
    EXPECT_NE(result.status().field().find(member), std::string::npos) << result.status().message();
  }
}

TEST(ScoreJsonTest, NamesThatAreNotKnownAreRefused) {
  const auto field = [](const std::string& from, const std::string& to) {
    std::string spoiled = ToJson(Filled());
    EXPECT_NE(spoiled.find(from), std::string::npos) << from;
    spoiled.replace(spoiled.find(from), from.size(), to);
    return ScoreFromJson(spoiled).status().field();
  };
  EXPECT_EQ(field("\"kind\":\"under_extended\"", "\"kind\":\"ugly\""), "mistakes[0].kind");
  EXPECT_EQ(field("\"group\":\"outline\"", "\"group\":\"beauty\""), "criteria[0].group");
  EXPECT_EQ(field("\"state\":\"modify\"", "\"state\":\"fine\""), "criteria[0].state");
  EXPECT_EQ(field("\"dearer\":\"over\"", "\"dearer\":\"both\""), "regions[0].dearer");
  EXPECT_EQ(field("\"acceptance\":\"", "\"acceptance\":\"x"), "acceptance");
}

TEST(ScoreJsonTest, MoreThanAScoreCanHoldIsRefused) {
  const auto refused = [](const std::function<void(ScoreResult&)>& change) {
    ScoreResult r = Filled();
    change(r);
    return ScoreFromJson(ToJson(r)).status().field();
  };
  EXPECT_EQ(refused([](ScoreResult& r) { r.mistakes.resize(kMaxMistakes + 1); }), "mistakes");
  EXPECT_EQ(refused([](ScoreResult& r) { r.criteria.resize(kMaxCriteria + 1); }), "criteria");
  EXPECT_EQ(refused([](ScoreResult& r) { r.deductions.resize(kMaxDeductions + 1); }), "deductions");
  EXPECT_EQ(refused([](ScoreResult& r) {
              r.measures.resize(kMaxMeasures + 1, {"floor", "floor", 0, 0});
              r.costs.resize(kMaxMeasures + 1);
            }),
            "regions");
}

TEST(ScoreJsonTest, WrongTypesAndOversizeAreRefused) {
  EXPECT_FALSE(ScoreFromJson("[]").ok());
  EXPECT_FALSE(ScoreFromJson("{}").ok());
  std::string negative = ToJson(Filled());
  negative.replace(negative.find("\"gap_ticks\":7"), 13, "\"gap_ticks\":-7");
  EXPECT_FALSE(ScoreFromJson(negative).ok());
  EXPECT_EQ(ScoreFromJson(std::string(kMaxScoreJsonBytes + 1, ' ')).status().code(),
            Code::kTooLarge);
}

}  // namespace
}  // namespace enamel::scoring
