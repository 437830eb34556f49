#include "common/scoring/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace enamel::scoring {
namespace {

using scene::Rubric;
using scene::RubricCriterion;

RubricCriterion Wall() {
  return {"wall_mesial_mm",
          "Mesial wall",
          "mm",
          60,
          {{-0.3, 0}, {-0.05, 1}, {0.05, 1}, {0.3, 0}},
          "Watch the line angle.",
          {}};
}
RubricCriterion Target() {
  return {"zone_target_removed_percent", "Target removed", "%", 20, {{80, 0}, {95, 1}}, "", {}};
}
RubricCriterion Pulp() {
  return {"pulp_exposed_mm2",           "Pulp", "mm2", 20, {{0, 1}, {0.01, 0}},
          "The pulp must stay closed.", 0.01};
}
Rubric Three() { return {"class-1", 3, {Wall(), Target(), Pulp()}, {}}; }

MetricSet Values(double wall, double target, double pulp) {
  return {{{"wall_mesial_mm", wall, "mm"},
           {"zone_target_removed_percent", target, "%"},
           {"pulp_exposed_mm2", pulp, "mm2"}},
          {}};
}

ScoreResult Score(double wall, double target, double pulp) {
  auto result = ApplyRubric(Three(), Values(wall, target, pulp));
  EXPECT_TRUE(result.ok()) << result.status().message();
  return result.ok() ? *result : ScoreResult{};
}

// "0.03 mm (full marks up to 0.03 mm)" with points lost is a riddle.
TEST(ApplyRubricTest, LimitsAreShownAsTheyAreAndWhatMissesThemDoesNotReadLikeThem) {
  auto reason = [](double limit, double value) {
    RubricCriterion waves{
        "wall_waviness_mm", "Walls smooth", "mm", 10, {{limit, 1}, {0.1, 0}}, "", {}};
    auto scored = ApplyRubric({"r", 1, {waves}, {}}, {{{"wall_waviness_mm", value, "mm"}}, {}});
    EXPECT_TRUE(scored.ok());
    return scored->criteria[0].reason;
  };
  EXPECT_EQ(reason(0.025, 0.031),
            "Walls smooth: 0.03 mm (full marks up to 0.025 mm, none from 0.10 mm).");
  EXPECT_EQ(reason(0.05, 0.0504),
            "Walls smooth: 0.0504 mm (full marks up to 0.05 mm, none from 0.10 mm).");
  EXPECT_EQ(reason(0.05, 0.0998),
            "Walls smooth: 0.10 mm (full marks up to 0.05 mm, none from 0.10 mm).");
  EXPECT_EQ(reason(0.0285, 0.028), "Walls smooth: 0.028 mm (full marks up to 0.0285 mm).");
  EXPECT_EQ(reason(0.05, 0.04), "Walls smooth: 0.04 mm (full marks up to 0.05 mm).");
}

TEST(ApplyRubricTest, FullMarksAreAHundred) {
  ScoreResult r = Score(0, 99, 0);
  EXPECT_EQ(r.score, 100);
  EXPECT_FALSE(r.critical_fail);
  EXPECT_EQ(r.rubric_version, 3);
  EXPECT_EQ(r.criteria[0].reason, "Mesial wall: 0.00 mm off (full marks within 0.05 mm).");
}

TEST(ApplyRubricTest, PointsAreLinearBetweenTheMapsPointsAndConstantBeyond) {
  EXPECT_NEAR(Score(0.175, 99, 0).criteria[0].points, 30, 1e-12);  // halfway down
  EXPECT_NEAR(Score(-0.175, 99, 0).criteria[0].points, 30, 1e-12);
  EXPECT_NEAR(Score(0, 87.5, 0).criteria[1].points, 10, 1e-12);
  EXPECT_EQ(Score(5, 99, 0).criteria[0].points, 0);
  EXPECT_EQ(Score(0, 10, 0).criteria[1].points, 0);
  EXPECT_EQ(Score(0, 100, 0).criteria[1].points, 20);
}

TEST(ApplyRubricTest, TheScoreIsTheShareOfAllPoints) {
  Rubric rubric{"half", 1, {Wall()}, {}};
  auto r = ApplyRubric(rubric, Values(0.175, 0, 0));
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(r->score, 50, 1e-12);
}

TEST(ApplyRubricTest, ReasonsSayWhatWasFoundAndWhatWasAskedFor) {
  ScoreResult r = Score(0.3, 91.2, 0);
  EXPECT_EQ(
      r.criteria[0].reason,
      "Mesial wall: 0.30 mm too deep (full marks within 0.05 mm, none beyond 0.30 mm). Watch the "
      "line angle.");
  EXPECT_EQ(r.criteria[1].reason,
            "Target removed: 91.2 % (full marks from 95.0 %, none up to 80.0 %).");
  EXPECT_EQ(r.criteria[2].reason, "Pulp: 0.00 mm² (full marks at 0.00 mm²).");
  EXPECT_EQ(
      Score(-0.2, 99, 0).criteria[0].reason,
      "Mesial wall: 0.20 mm short (full marks within 0.05 mm, none beyond 0.30 mm). Watch the "
      "line angle.");
}

Deduction WallTooDeep() {
  Deduction d;
  d.criterion = "wall_mesial_mm";
  d.volume_m3 = 1e-9;
  d.first_s = 72.4;
  d.stroke_count = 2;
  d.half_s = 80.6;
  d.strokes = {{14, 80'000, 80, 2, 0.9e-9}, {12, 72'400, 72.4, 1, 0.1e-9}};
  d.strokes_m3 = 1e-9;
  return d;
}

TEST(ApplyRubricTest, AdviceNamesTheMomentAndTheStrokeThatTookMost) {
  ScoreResult r = Score(0.2, 99, 0);
  Advise(Three(), {WallTooDeep()}, r);
  EXPECT_EQ(r.criteria[0].reasons,
            (std::vector<Reason>{{"within", {0.2, 0.05, 0.3}, {"mm", "mm", "mm"}},
                                 {"stop_earlier", {72.4, 14}, {"s", "count"}}}));
  EXPECT_EQ(r.criteria[0].reason,
            "Mesial wall: 0.20 mm too deep (full marks within 0.05 mm, none beyond 0.30 mm). It "
            "began at 1:12, and stroke 14 removed most of it. Stop earlier there. Watch the line "
            "angle.");
  EXPECT_EQ(r.deductions.size(), 1u);
}

// No stroke could have been left out where none took half, or where one lasts for a third of the
// attempt.
TEST(ApplyRubricTest, AdviceNamesAMomentWhereNoOneStrokeIsToBlame) {
  Deduction shared = WallTooDeep(), lasting = WallTooDeep();
  shared.strokes_m3 = 2e-9;
  shared.here = true;
  lasting.strokes[0].lasts_s = 70;
  const MetricInfo& wall = *FindMetric("wall_mesial_mm");
  const auto sentence = [&](const Deduction& d) {
    return Sentence("Wall", wall, {*Advice(wall, 0.2, Three().criteria[0].map, {d})}, "");
  };
  EXPECT_EQ(sentence(shared),
            "Wall: At the worst spot, it began at 1:12, and half of it was gone by 1:21. Stop "
            "earlier there.");
  EXPECT_EQ(sentence(lasting),
            "Wall: It began at 1:12, and half of it was gone by 1:21. Stop earlier there.");
  shared.strokes_m3 = 1e-9;
  EXPECT_EQ(
      sentence(shared),
      "Wall: At the worst spot, it began at 1:12, and stroke 14 removed most of it. Stop earlier "
      "there.");
}

TEST(ApplyRubricTest, AdviceOfAWallTakesTheSideThatItIsOffOn) {
  ScoreResult r = Score(-0.2, 99, 0);
  Deduction left;
  left.criterion = "wall_mesial_mm";
  left.left = true;
  left.volume_m3 = 0.52e-9;
  Advise(Three(), {WallTooDeep(), left}, r);
  EXPECT_NE(r.criteria[0].reason.find(" 0.52 mm³ was left uncut. Cut further there."),
            std::string::npos)
      << r.criteria[0].reason;
  EXPECT_EQ(r.criteria[0].reason.find("stroke"), std::string::npos) << r.criteria[0].reason;
}

TEST(ApplyRubricTest, ASmallLossIsNotToldInTheWordsOfAFault) {
  // 60 points of a hundred: 2.4 lost at 0.06 mm, 6 at 0.075 mm.
  ScoreResult small = Score(0.06, 99, 0);
  Advise(Three(), {WallTooDeep()}, small);
  EXPECT_TRUE(small.criteria[0].comment.empty()) << small.criteria[0].reason;
  EXPECT_NE(small.criteria[0].reason.find("Stop earlier there."), std::string::npos);
  EXPECT_FALSE(Score(0.075, 99, 0).criteria[0].comment.empty());
  // A light criterion speaks from a quarter of its points on.
  Rubric light = Three();
  light.criteria[0].points = 4;
  auto lost = [&](double mm) {
    auto r = ApplyRubric(light, Values(mm, 99, 0));
    EXPECT_TRUE(r.ok());
    return r->criteria[0];
  };
  EXPECT_TRUE(lost(0.1).comment.empty()) << "0.8 of 4";
  EXPECT_FALSE(lost(0.12).comment.empty()) << "1.1 of 4";
}

TEST(ApplyRubricTest, TheSameAdviceIsToldOnceWhereItCostMost) {
  Rubric rubric = Three();
  RubricCriterion other = rubric.criteria[0];
  other.metric = "wall_distal_mm";
  other.title = "Distal wall";
  other.points = 80;
  rubric.criteria.insert(rubric.criteria.begin() + 1, other);
  MetricSet metrics = Values(0.2, 99, 0);
  metrics.values.push_back({"wall_distal_mm", 0.2, "mm"});
  auto result = ApplyRubric(rubric, metrics);
  ASSERT_TRUE(result.ok()) << result.status().message();
  Deduction same = WallTooDeep();
  same.criterion = "wall_distal_mm";
  Advise(rubric, {WallTooDeep(), same}, *result);
  EXPECT_EQ(result->criteria[0].reason.find("stroke 14"), std::string::npos);
  EXPECT_NE(result->criteria[1].reason.find("stroke 14"), std::string::npos);
  EXPECT_EQ(result->criteria[0].reasons.size(), 1u);
  EXPECT_EQ(result->deductions.size(), 2u) << "both places are shown";
  // Another stroke is other words.
  auto apart = ApplyRubric(rubric, metrics);
  same.strokes[0].number = 15;
  Advise(rubric, {WallTooDeep(), same}, *apart);
  EXPECT_NE(apart->criteria[0].reason.find("stroke 14"), std::string::npos);
  EXPECT_NE(apart->criteria[1].reason.find("stroke 15"), std::string::npos);
}

TEST(ApplyRubricTest, WhoLostLessThanHalfAPointNeedsNoAdvice) {
  ScoreResult r = Score(0.051, 99, 0);  // 0.24 of 60 points
  Advise(Three(), {WallTooDeep()}, r);
  EXPECT_LT(r.criteria[0].points, 60);
  EXPECT_EQ(r.criteria[0].reason,
            "Mesial wall: 0.051 mm too deep (full marks within 0.05 mm, none beyond 0.30 mm).");
  EXPECT_TRUE(r.criteria[0].comment.empty());
}

TEST(SentenceTest, ACodeThatIsNotKnownIsLeftOut) {
  const MetricInfo& wall = *FindMetric("wall_mesial_mm");
  EXPECT_EQ(Sentence("Wall", wall, {{"any", {0.4}, {"mm"}}, {"of_tomorrow", {1}, {"s"}}}, "Oh."),
            "Wall: 0.40 mm too deep. Oh.");
  EXPECT_EQ(Sentence("Wall", wall, {{"within", {}, {}}, {"stop_earlier", {1}, {"s"}}}, ""), "Wall:")
      << "too few values";
}

TEST(ApplyRubricTest, ACriticalFailScoresZeroAndSaysWhy) {
  ScoreResult r = Score(0, 99, 0.42);
  EXPECT_EQ(r.score, 0);
  EXPECT_TRUE(r.critical_fail);
  EXPECT_EQ(r.criteria[0].points, 60) << "what was good is still shown";
  EXPECT_EQ(
      r.criteria[2].reason,
      "Pulp: 0.42 mm² (more than 0.01 mm² fails the whole attempt). The pulp must stay closed.");
}

TEST(ApplyRubricTest, AMissingOrInfiniteMetricIsRefusedByName) {
  auto missing = ApplyRubric(Three(), MetricSet{{{"wall_mesial_mm", 0, "mm"}}, {}});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.status().field(), "zone_target_removed_percent");
  EXPECT_FALSE(ApplyRubric(Three(), Values(1.0 / 0.0, 99, 0)).ok());
}

scene::RubricGate Done() {
  return {"task_done_percent", "Task done", "%", {{0, 0}, {90, 1}}, "The work was stopped early."};
}

MetricSet WithDone(double percent) {
  MetricSet out = Values(0, 99, 0);
  out.values.push_back({"task_done_percent", percent, "%"});
  return out;
}

TEST(ApplyRubricTest, AGateTakesItsShareOfEveryCriterion) {
  Rubric rubric = Three();
  rubric.gates = {Done()};
  auto half = ApplyRubric(rubric, WithDone(45));
  ASSERT_TRUE(half.ok()) << half.status().message();
  EXPECT_NEAR(half->score, 50, 1e-12);
  double sum = 0;
  for (const CriterionResult& c : half->criteria) sum += c.points;
  EXPECT_NEAR(sum, 50, 1e-12) << "the points shown are those that count";
  EXPECT_EQ(half->gates[0].reason,
            "Task done: 45.0 % (full marks from 90.0 %, none up to 0.0 %). Every criterion keeps "
            "50.0 % of its points. The work was stopped early.");
  EXPECT_EQ(ApplyRubric(rubric, WithDone(0))->score, 0);
  auto whole = ApplyRubric(rubric, WithDone(97));
  EXPECT_EQ(whole->score, 100);
  EXPECT_EQ(whole->gates[0].reason, "Task done: 97.0 % (full marks from 90.0 %).");
}

// A wall that is too far out made a place deep: the place is charged for what the wall leaves over.
TEST(ApplyRubricTest, OneMistakeIsChargedUnderOneCriterion) {
  Rubric rubric{"class-1", 3, {Wall()}, {}};
  rubric.criteria.push_back(
      {"deepest_over_mm", "No gouge", "mm", 10, {{0.1, 1}, {0.3, 0}}, "", {}});
  MetricSet metrics{{{"wall_mesial_mm", 0.3, "mm"}, {"deepest_over_mm", 0.3, "mm"}}, {}};
  EXPECT_EQ(ApplyRubric(rubric, metrics)->criteria[1].points, 0);

  metrics.values[1].charged = 0.05;
  metrics.values[1].under = {"floor_mm", "wall_mesial_mm"};
  const ScoreResult once = *ApplyRubric(rubric, metrics);
  EXPECT_EQ(once.criteria[1].points, 10);
  EXPECT_EQ(once.criteria[1].value, 0.3);
  EXPECT_EQ(once.criteria[1].charged, 0.05);
  EXPECT_EQ(once.criteria[1].under, rubric.criteria[0].title);
  EXPECT_NE(once.criteria[1].reason.find("not counted twice"), std::string::npos);

  // Nothing else in the rubric is about the wall.
  metrics.values[1].under = {"floor_mm"};
  const ScoreResult alone = *ApplyRubric(rubric, metrics);
  EXPECT_EQ(alone.criteria[1].points, 0);
  EXPECT_EQ(alone.criteria[1].charged, 0.3);
  EXPECT_TRUE(alone.criteria[1].under.empty());
}

// A gate takes the value as measured. Its advice is that of the wall which explains the value.
TEST(ApplyRubricTest, AGateThatAWallClosedAdvisesAsTheWallDoes) {
  Rubric rubric{"class-1", 3, {Wall()}, {}};
  rubric.criteria.push_back({"crown_axis_deg", "Upright", "deg", 3, {{8, 1}, {18, 0}}, "", {}});
  rubric.gates = {{"deepest_over_mm", "No second hole", "mm", {{0.6, 1}, {1.6, 0}}, ""}};
  MetricSet metrics{
      {{"wall_mesial_mm", 0, "mm"}, {"crown_axis_deg", 14, "deg"}, {"deepest_over_mm", 1.1, "mm"}},
      {}};
  EXPECT_FALSE(CriterionBehind(rubric, *ApplyRubric(rubric, metrics), 0));
  metrics.values[2].charged = 0.1;
  metrics.values[2].under = {"wall_mesial_mm", "crown_axis_deg"};
  ScoreResult r = *ApplyRubric(rubric, metrics);
  EXPECT_EQ(CriterionBehind(rubric, r, 0), 1u) << "the wall is right";
  Advise(rubric, {}, r);
  EXPECT_NE(r.gates[0].reason.find("long axis"), std::string::npos) << r.gates[0].reason;
  metrics.values[2].charged = 1;
  EXPECT_FALSE(CriterionBehind(rubric, *ApplyRubric(rubric, metrics), 0)) << "most is its own";
}

TEST(ApplyRubricTest, SeveralGatesMultiply) {
  Rubric rubric = Three();
  rubric.gates = {Done(), {"damage_percent", "Damage", "%", {{0, 1}, {100, 0}}, ""}};
  MetricSet metrics = WithDone(45);
  metrics.values.push_back({"damage_percent", 50, "%"});
  EXPECT_NEAR(ApplyRubric(rubric, metrics)->score, 25, 1e-12);
}

TEST(ApplyRubricTest, WhatIsNotInTheTaskCountsNeitherWay) {
  MetricSet metrics = Values(0, 87.5, 0);
  metrics.values.erase(metrics.values.begin());
  metrics.missing = {{"wall_mesial_mm", NoValue::kNotInTask}};
  auto r = ApplyRubric(Three(), metrics);
  ASSERT_TRUE(r.ok()) << r.status().message();
  EXPECT_NEAR(r->score, 75, 1e-12);  // 10 + 20 of 20 + 20
  EXPECT_FALSE(r->criteria[0].judged);
  EXPECT_EQ(r->criteria[0].max_points, 0);
  EXPECT_EQ(r->criteria[0].reason,
            "Mesial wall: not judged, because the reference has none of it.");
}

TEST(ApplyRubricTest, WhatWasNotMadeEarnsNothing) {
  MetricSet metrics = Values(0, 99, 0);
  metrics.values.erase(metrics.values.begin());
  metrics.missing = {{"wall_mesial_mm", NoValue::kNotMade}};
  auto r = ApplyRubric(Three(), metrics);
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(r->score, 40, 1e-12);
  EXPECT_EQ(r->criteria[0].max_points, 60);
  EXPECT_EQ(r->criteria[0].reason, "Mesial wall: there is nothing to measure yet.");
}

TEST(ApplyRubricTest, ARubricOfWhichNothingCanBeJudgedIsRefused) {
  Rubric rubric{"one", 1, {Wall()}, {}};
  MetricSet metrics;
  metrics.missing = {{"wall_mesial_mm", NoValue::kNotInTask}};
  EXPECT_EQ(ApplyRubric(rubric, metrics).status().field(), "criteria");
}

TEST(ApplyRubricTest, AGateWithoutAValueIsRefusedByName) {
  Rubric rubric = Three();
  rubric.gates = {{"caries_left_percent", "Caries", "%", {{0, 1}, {50, 0}}, ""}};
  MetricSet metrics = Values(0, 99, 0);
  metrics.missing = {{"caries_left_percent", NoValue::kNotInTask}};
  EXPECT_EQ(ApplyRubric(rubric, metrics).status().field(), "caries_left_percent");
}

TEST(ValidateRubricTest, RefusesWhatCannotBeScoredAndNamesIt) {
  struct Case {
    const char* field;
    std::function<void(Rubric&)> spoil;
  };
  const Case cases[] = {
      {"criteria[0].metric", [](Rubric& r) { r.criteria[0].metric = "beauty"; }},
      {"criteria[1].unit", [](Rubric& r) { r.criteria[1].unit = "mm"; }},
      {"criteria[0].map", [](Rubric& r) { r.criteria[0].map.clear(); }},
      {"criteria[0].map", [](Rubric& r) { std::swap(r.criteria[0].map[0], r.criteria[0].map[1]); }},
      {"criteria[0].map", [](Rubric& r) { r.criteria[0].map[1].share = 1.5; }},
      {"criteria[2].points", [](Rubric& r) { r.criteria[2].points = -1; }},
      {"criteria[2].fails_above", [](Rubric& r) { r.criteria[2].fails_above = 0.0 / 0.0; }},
      {"criteria", [](Rubric& r) { r.criteria.clear(); }},
      {"criteria",
       [](Rubric& r) {
         for (auto& c : r.criteria) c.points = 0;
       }},
      {"criteria", [](Rubric& r) { r.criteria.resize(kMaxCriteria + 1, Wall()); }},
      {"critical[0].error",
       [](Rubric& r) {
         r.critical = {{"ugly", "time_s", "s", 1, true, "x"}};
       }},
      {"critical[0].unit",
       [](Rubric& r) {
         r.critical = {{"all_cut", "time_s", "mm", 1, true, "x"}};
       }},
      {"critical", [](Rubric& r) { r.critical.resize(kMaxCritical + 1); }},
      {"gates[0].metric",
       [](Rubric& r) {
         r.gates = {Done()};
         r.gates[0].metric = "x";
       }},
      {"gates[0].unit",
       [](Rubric& r) {
         r.gates = {Done()};
         r.gates[0].unit = "mm";
       }},
      {"gates[1].map",
       [](Rubric& r) {
         r.gates = {Done(), Done()};
         r.gates[1].map.clear();
       }},
      {"gates", [](Rubric& r) { r.gates.resize(kMaxGates + 1, Done()); }},
  };
  for (const Case& c : cases) {
    Rubric rubric = Three();
    c.spoil(rubric);
    Status status = ValidateRubric(rubric);
    EXPECT_EQ(status.code(), Code::kInvalidInput);
    EXPECT_EQ(status.field(), c.field) << status.message();
  }
  EXPECT_TRUE(ValidateRubric(Three()).ok());
}

// A later rubric may need an unmeasured metric: the error names it, and no points are made up.
TEST(ApplyRubricTest, AMetricThatWasNotMeasuredIsRefusedByName) {
  MetricSet metrics = Values(0, 99, 0);
  const std::string name = Three().criteria[0].metric;
  std::erase_if(metrics.values, [&](const MetricValue& m) { return m.name == name; });
  metrics.missing = {{name, NoValue::kNotUsed}};
  auto result = ApplyRubric(Three(), metrics);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().field(), name);
  EXPECT_NE(result.status().message().find("again"), std::string::npos);
}

Rubric WithForce() {
  Rubric rubric = Three();
  rubric.criteria.push_back(
      {"force_sent_p95_n", "Light hand", "N", 10, {{4, 1}, {8, 0}}, "Let it cut.", {}});
  return rubric;
}
MetricSet WithForceOf(double force_n, bool limited) {
  MetricSet metrics = Values(0, 99, 0);
  metrics.values.push_back({"force_sent_p95_n", force_n, "N", limited});
  return metrics;
}

TEST(ApplyRubricTest, AThicknessBelowWhatTheGridMeasuresIsToldBesideTheValue) {
  Rubric rubric = Three();
  rubric.criteria.push_back(
      {"remaining_dentin_mm", "Cover", "mm", 10, {{0.5, 0}, {0.9, 1}}, "", {}});
  MetricSet metrics = Values(0, 99, 0);
  metrics.values.push_back({"remaining_dentin_mm", 0.12, "mm"});
  EXPECT_EQ(ApplyRubric(rubric, metrics)->criteria.back().reason.find("grid"), std::string::npos);
  metrics.values.back().below_grid = 0.2;
  const CriterionResult told = ApplyRubric(rubric, metrics)->criteria.back();
  EXPECT_EQ(
      told.reason,
      "Cover: 0.12 mm (full marks from 0.90 mm, none up to 0.50 mm). Thinner than 0.20 mm: the "
      "grid cannot measure it more exactly.");
  EXPECT_EQ(told.value, 0.12);
  rubric.gates.push_back({"remaining_dentin_mm", "Cover", "mm", {{0, 0}, {0.5, 1}}, ""});
  EXPECT_NE(ApplyRubric(rubric, metrics)->gates.back().reason.find("the grid cannot measure it"),
            std::string::npos);
}

// A device that cannot press back as hard as the hand presses says nothing of how light it is.
TEST(ApplyRubricTest, AForceAtTheDevicesLimitIsNotJudgedAndItsPointsAreNobodys) {
  const ScoreResult without = *ApplyRubric(Three(), Values(0, 99, 0));
  for (double force : {2.0, 6.0}) {
    const ScoreResult hidden = *ApplyRubric(WithForce(), WithForceOf(force, true));
    EXPECT_EQ(hidden.score, without.score) << "the other criteria share a hundred among them";
    const CriterionResult& c = hidden.criteria.back();
    EXPECT_FALSE(c.judged);
    EXPECT_EQ(c.max_points, 0);
    EXPECT_EQ(c.value, force);
    EXPECT_NE(c.reason.find("at its limit"), std::string::npos) << c.reason;
    EXPECT_EQ(CostlyCriteria(WithForce(), hidden), CostlyCriteria(Three(), without));
  }
  const ScoreResult judged = *ApplyRubric(WithForce(), WithForceOf(6, false));
  EXPECT_EQ(judged.criteria.back().points, 5);
  EXPECT_TRUE(judged.criteria.back().judged);
}

// Or pressing as hard as one can would be a way out.
TEST(ApplyRubricTest, AForceThatCostsAllAtLeastStaysJudgedAtTheLimit) {
  const ScoreResult all = *ApplyRubric(WithForce(), WithForceOf(8.5, true));
  EXPECT_TRUE(all.criteria.back().judged);
  EXPECT_EQ(all.criteria.back().points, 0);
  EXPECT_EQ(all.criteria.back().max_points, 10);
  Rubric critical = WithForce();
  critical.criteria.back().fails_above = 7;
  EXPECT_TRUE(ApplyRubric(critical, WithForceOf(7.5, true))->critical_fail);
  EXPECT_FALSE(ApplyRubric(critical, WithForceOf(6.5, true))->critical_fail);
  EXPECT_FALSE(ApplyRubric(critical, WithForceOf(6.5, true))->criteria.back().judged);
}

scene::RubricCritical ShortWall() {
  return {"contact_left", "wall_mesial_mm", "mm", -0.2, false, "a textbook"};
}

ScoreResult Filled() {
  Rubric rubric = Three();
  rubric.critical = {ShortWall()};
  rubric.critical[0].limit = 1;
  rubric.gates = {Done()};
  MetricSet metrics = Values(0.1 + 0.2, 91.234567890123456, 0);
  metrics.values.push_back({"task_done_percent", 66.6, "%", false, 70.5, {"floor_mm"}});
  metrics.missing = {{"caries_left_mm3", NoValue::kNotInTask},
                     {"tilt_mesial_deg", NoValue::kNotMade},
                     {"dtw_pose_mm", NoValue::kNotUsed}};
  ScoreResult r = *ApplyRubric(rubric, metrics);
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
  over.criterion = "wall_mesial_mm";
  over.volume_m3 = 1.23456789e-9;
  over.position_m = {1.7e-3, -0.123456789e-3, -1e-3};
  over.facing = {-1, 0, 0};
  over.first_tick = 5'000'000'000;
  over.first_s = 72.125;
  over.stroke_count = 2;
  over.strokes = {{7, 5'000'000'000, 72.125, 1e-9}, {3, 6'000'000'000, 80, 0.23456789e-9}};
  Deduction left;
  left.criterion = "missed_mm3";
  left.left = true;
  left.volume_m3 = 0.1e-9;
  Advise(rubric, {over, left}, r);
  r.witness_note = "tick 12: \"force_sent\"\n";
  return r;
}

TEST(ScoreJsonTest, ReadsBackToTheSameScore) {
  auto back = ScoreFromJson(ToJson(Filled()));
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(ToJson(*back), ToJson(Filled()));
  EXPECT_NEAR(back->score, Filled().score, 1e-10);
  EXPECT_EQ(back->criteria.size(), 3u);
  EXPECT_EQ(back->criteria[0].reasons[1], Filled().criteria[0].reasons[1]);
  EXPECT_EQ(back->criteria[1].reason, Filled().criteria[1].reason);
  EXPECT_EQ(back->ticks, 123'456'789'012u);
  EXPECT_EQ(back->outages, 10u);
  ASSERT_EQ(back->deductions.size(), 2u);
  EXPECT_EQ(back->deductions[0].strokes[1].first_tick, 6'000'000'000u);
  EXPECT_NEAR(back->deductions[0].position_m.y, -0.123456789e-3, 1e-15);
  EXPECT_TRUE(back->deductions[1].left);
  EXPECT_EQ(back->witness_note, Filled().witness_note);
  EXPECT_TRUE(back->disturbance.disturbed());
  EXPECT_NEAR(back->disturbance.limited_percent, 7.0 / 3, 1e-10);
  EXPECT_TRUE(back->metrics.back().limited);
  EXPECT_FALSE(back->metrics.front().limited);
  EXPECT_EQ(back->metrics.front().below_grid, 0.2);
  EXPECT_FALSE(back->metrics.back().below_grid);
  EXPECT_EQ(*ScoreFromJson(ToJson(*back)), *back);
}

TEST(ScoreJsonTest, NumbersOfAnySizeSurviveAnyNumberOfTrips) {
  ScoreResult r = Filled();
  uint64_t bits = 0x3ff123456789abcd;
  for (int i = 0; i < 2000; ++i) {
    bits = bits * 6364136223846793005u + 1442695040888963407u;
    r.metrics[0].value = static_cast<double>(bits >> 11) * std::pow(10, -10 - i % 12);
    std::string once = ToJson(r);
    auto back = ScoreFromJson(once);
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(ToJson(*back), once);
  }
}

TEST(ScoreJsonTest, EveryTruncationAndEveryMissingMemberIsRefused) {
  std::string text = ToJson(Filled());
  for (size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(ScoreFromJson(text.substr(0, n)).ok());
  for (const char* member :
       {"score",          "critical_fail",   "critical", "points",      "acceptance", "above",
        "criteria",       "gates",           "metrics",  "missing",     "deductions", "envelope",
        "rubric_version", "scoring_version", "ticks",    "disturbance", "witness_ok", "max_points",
        "reason",         "judged",          "reasons",  "comment",     "lasts_s",    "here"}) {
    std::string spoiled = text;
    spoiled.replace(spoiled.find("\"" + std::string(member) + "\""), std::strlen(member) + 2,
                    "\"x\"");
    auto result = ScoreFromJson(spoiled);
    ASSERT_FALSE(result.ok()) << member;
    EXPECT_NE(result.status().field().find(member), std::string::npos) << result.status().message();
  }
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
