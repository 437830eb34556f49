#include "common/scoring/tolerances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "common/scoring/score.h"

namespace enamel::scoring {
namespace {

using scene::Restoration;
using scene::Rubric;

// Ten points for how walls lean outwards, ten for undercuts. By itself: full marks up to 2 degrees.
Rubric FilledCavity(Restoration restoration) {
  Rubric r{"cavity",
           1,
           {{"wall_tilt_deg", "Walls upright", "deg", 10, {{2, 1}, {10, 0}}, "", {}},
            {"undercut_deg", "No undercut", "deg", 10, {{2, 1}, {8, 0}}, "", {}}},
           {},
           {{"contact_left", "contact_left_percent", "%", 25, true, "x"}}};
  r.restoration = restoration;
  r.restorations = {{Restoration::kAmalgam,
                     "x",
                     {{{-2, 10}, {-5, 2}}},
                     {{"wall_tilt_deg", {{0, 1}, {8, 0}}}, {"undercut_deg", {{0, 1}, {6, 0}}}},
                     {}},
                    {Restoration::kComposite,
                     "x",
                     {},
                     {{"wall_tilt_deg", {{10, 1}, {18, 0}}}, {"undercut_deg", {{5, 1}, {11, 0}}}},
                     {{"contact_left", "contact_left_percent", 50}}},
                    {Restoration::kCeramic,
                     "x",
                     {{{3, 10}, {3, 10}}},
                     {{"wall_tilt_deg", {{0, 1}, {8, 0}}}, {"undercut_deg", {{0.5, 1}, {2, 0}}}},
                     {}}};
  return r;
}

// Leans by how far they diverge, beside an upright reference.
struct Leans {
  double mesial = 0, distal = 0, buccal = 0, lingual = 0;
};
MetricSet WithLeans(const Leans& w, double contact_percent = 0) {
  const double most = std::max(
      {std::fabs(w.mesial), std::fabs(w.distal), std::fabs(w.buccal), std::fabs(w.lingual)});
  const double in = std::max({0.0, -w.mesial, -w.distal, -w.buccal, -w.lingual});
  MetricSet out;
  for (const auto& [name, angle] : {std::pair{"mesial", w.mesial},
                                    {"distal", w.distal},
                                    {"buccal", w.buccal},
                                    {"lingual", w.lingual}}) {
    out.values.push_back({std::string("tilt_") + name + "_deg", angle, "deg"});
    out.values.push_back({std::string("divergence_") + name + "_deg", angle, "deg"});
  }
  MetricValue tilt{"wall_tilt_deg", most, "deg"};
  // As FindCharges has it: what leans in is the undercut's.
  if (in > 0) tilt.charged = 0, tilt.under = {"undercut_deg"};
  out.values.push_back(tilt);
  out.values.push_back({"undercut_deg", in, "deg"});
  out.values.push_back({"contact_left_percent", contact_percent, "%"});
  return out;
}

ScoreResult ScoreFor(Restoration restoration, const MetricSet& metrics) {
  auto result = ApplyRubric(FilledCavity(restoration), metrics);
  EXPECT_TRUE(result.ok()) << result.status().message();
  return result.ok() ? *result : ScoreResult{};
}
double PointsFor(Restoration restoration, const Leans& walls) {
  return ScoreFor(restoration, WithLeans(walls)).points;
}

constexpr Leans kAmalgamForm{.mesial = 6, .distal = 8, .buccal = -4, .lingual = -3};

TEST(TolerancesTest, TheUsualFormForAmalgamLosesPointsOnlyWhereTheRubricNamesNoMaterial) {
  EXPECT_LT(PointsFor(Restoration::kNone, kAmalgamForm), 90);
  EXPECT_EQ(PointsFor(Restoration::kAmalgam, kAmalgamForm), 100);
}

TEST(TolerancesTest, AmalgamAllowsConvergenceToBuccalAndLingualWallsOnly) {
  EXPECT_EQ(PointsFor(Restoration::kAmalgam, {.buccal = -5, .lingual = -5}), 100);
  // 3 of the 6 degrees after which undercut_deg gives no points.
  EXPECT_NEAR(PointsFor(Restoration::kAmalgam, {.buccal = -8}), 75, 1e-9);
  EXPECT_NEAR(PointsFor(Restoration::kAmalgam, {.distal = -5}), 75, 1e-9);
  EXPECT_NEAR(PointsFor(Restoration::kAmalgam, {.lingual = 6}), 75, 1e-9);
  EXPECT_EQ(PointsFor(Restoration::kAmalgam, {.distal = 10}), 100);
  EXPECT_NEAR(PointsFor(Restoration::kAmalgam, {.distal = 14}), 75, 1e-9);
}

TEST(TolerancesTest, UnderCeramicEveryUndercutIsOneAndWallsMustDiverge) {
  const ScoreResult found = ScoreFor(Restoration::kCeramic, WithLeans(kAmalgamForm));
  EXPECT_EQ(found.criteria[1].points, 0);
  EXPECT_EQ(found.criteria[1].value, 4);
  EXPECT_EQ(found.criteria[1].charged, 4);
  EXPECT_EQ(found.criteria[1].reason, "No undercut: 4.0° (full marks up to 0.5°, none from 2.0°).");
  const Leans taper{.mesial = 3, .distal = 10, .buccal = 5, .lingual = 9};
  EXPECT_EQ(PointsFor(Restoration::kCeramic, taper), 100);
  EXPECT_LT(PointsFor(Restoration::kNone, taper), 60);
  // Of the 8 degrees after which there are no points.
  MetricSet steep = WithLeans({.mesial = 5, .distal = 5, .buccal = 1, .lingual = 5});
  EXPECT_NEAR(ScoreFor(Restoration::kCeramic, steep).criteria[0].points, 8.75, 1e-9)
      << "a wall leans by one degree from the reference's, which is all that it is charged for";
  for (MetricValue& m : steep.values) {
    if (m.name == "tilt_buccal_deg") m.value = -4;  // beside a reference that diverges by 5
  }
  const ScoreResult short_of = ScoreFor(Restoration::kCeramic, steep);
  EXPECT_NEAR(short_of.criteria[0].points, 7.5, 1e-9);
  EXPECT_EQ(short_of.criteria[0].reason, "Walls upright: 1.0° (full marks from 3.0° to 10.0°).");
}

TEST(TolerancesTest, AWallAsTheReferencesHasNoTilt) {
  MetricSet metrics = WithLeans({.buccal = 7});
  for (MetricValue& m : metrics.values) {
    if (m.name == "tilt_buccal_deg") m.value = 0;
  }
  EXPECT_EQ(ScoreFor(Restoration::kAmalgam, metrics).points, 100);
}

TEST(TolerancesTest, WithoutRangesTheMaterialsMapsAreForTheValues) {
  EXPECT_EQ(PointsFor(Restoration::kComposite, {.distal = -5, .buccal = 9}), 100);
  EXPECT_NEAR(PointsFor(Restoration::kComposite, {.distal = -8}), 75, 1e-9);
}

TEST(TolerancesTest, AContactThatAmalgamNeedsOpenMayBeLeftUnderComposite) {
  EXPECT_TRUE(ScoreFor(Restoration::kNone, WithLeans({}, 40)).critical_fail);
  EXPECT_TRUE(ScoreFor(Restoration::kAmalgam, WithLeans({}, 40)).critical_fail);
  EXPECT_FALSE(ScoreFor(Restoration::kComposite, WithLeans({}, 40)).critical_fail);
  EXPECT_TRUE(ScoreFor(Restoration::kComposite, WithLeans({}, 60)).critical_fail);
}

TEST(TolerancesTest, TheWholeIsTheSameUnderARubricThatNamesNone) {
  Rubric without = FilledCavity(Restoration::kNone);
  without.restorations.clear();
  EXPECT_EQ(*ApplyRubric(without, WithLeans(kAmalgamForm)),
            ScoreFor(Restoration::kNone, WithLeans(kAmalgamForm)));
  EXPECT_EQ(WithTolerances(FilledCavity(Restoration::kNone)), FilledCavity(Restoration::kNone));
}

TEST(TolerancesTest, WhatCostsAndWhatIsAdvisedIsByTheMaterialToo) {
  const Rubric amalgam = FilledCavity(Restoration::kAmalgam);
  EXPECT_TRUE(CostlyCriteria(amalgam, *ApplyRubric(amalgam, WithLeans(kAmalgamForm))).empty());
  ScoreResult leans = *ApplyRubric(amalgam, WithLeans({.distal = -6}));
  EXPECT_EQ(CostlyCriteria(amalgam, leans), std::vector<std::string>{"undercut_deg"});
  Advise(amalgam, {}, leans);
  EXPECT_EQ(leans.criteria[1].reasons.back().code, "do_upright");
  const Rubric ceramic = FilledCavity(Restoration::kCeramic);
  MetricSet upright = WithLeans({.mesial = 5, .distal = 5, .buccal = 0, .lingual = 5});
  for (MetricValue& m : upright.values) {
    if (m.name == "tilt_buccal_deg") m.value = -5;
  }
  ScoreResult too_upright = *ApplyRubric(ceramic, upright);
  Advise(ceramic, {}, too_upright);
  EXPECT_EQ(too_upright.criteria[0].reasons.back().code, "do_diverge");
  ScoreResult too_open = *ApplyRubric(ceramic, WithLeans({5, 5, 14, 5}));
  Advise(ceramic, {}, too_open);
  EXPECT_EQ(too_open.criteria[0].reasons.back().code, "do_parallel");
}

TEST(TolerancesTest, AWallOutOfTheTaskHasNoAngleAndOneThatWasNotMeasuredIsRefused) {
  MetricSet box = WithLeans({.mesial = -9, .buccal = -4});
  auto without = [&](NoValue why) {
    MetricSet out = box;
    std::erase_if(out.values, [](const auto& m) { return m.name == "divergence_mesial_deg"; });
    out.missing = {{"divergence_mesial_deg", why}};
    return ApplyRubric(FilledCavity(Restoration::kAmalgam), out);
  };
  EXPECT_EQ(without(NoValue::kNotInTask)->points, 100);
  EXPECT_EQ(without(NoValue::kNotUsed).status().field(), "divergence_mesial_deg");
}

TEST(TolerancesTest, RefusesAMaterialWithoutTolerancesAndTolerancesForNothing) {
  struct Case {
    const char* field;
    const char* said;
    std::function<void(Rubric&)> spoil;
  };
  const Case cases[] = {
      {"restoration", "no tolerances for amalgam", [](Rubric& r) { r.restorations.clear(); }},
      {"restoration", "undercut_deg depends on the material",
       [](Rubric& r) { r.restorations[0].criteria.pop_back(); }},
      {"restorations[1].restoration", "amalgam has tolerances already",
       [](Rubric& r) { r.restorations[1].restoration = Restoration::kAmalgam; }},
      {"restorations[1].restoration", "expected a material",
       [](Rubric& r) { r.restorations[1].restoration = Restoration::kNone; }},
      {"restorations[2].criteria[1].metric", "no criterion",
       [](Rubric& r) { r.restorations[2].criteria[1].metric = "floor_mm"; }},
      {"restorations[2].criteria[1].metric", "already",
       [](Rubric& r) { r.restorations[2].criteria[1] = r.restorations[2].criteria[0]; }},
      {"restorations[2].criteria[1].map", "at least one",
       [](Rubric& r) { r.restorations[2].criteria[1].map.clear(); }},
      {"restorations[1].critical[0].error", "no critical error",
       [](Rubric& r) { r.restorations[1].critical[0].error = "all_cut"; }},
      {"restorations[0].divergence_deg", "lesser angle first",
       [](Rubric& r) {
         r.restorations[0].divergence->buccolingual = {2, -5};
       }},
  };
  for (const Case& c : cases) {
    Rubric rubric = FilledCavity(Restoration::kAmalgam);
    c.spoil(rubric);
    const Status status = ValidateRubric(rubric);
    EXPECT_EQ(status.code(), Code::kInvalidInput);
    EXPECT_EQ(status.field(), c.field) << status.message();
    EXPECT_NE(status.message().find(c.said), std::string::npos) << status.message();
  }
  EXPECT_TRUE(ValidateRubric(FilledCavity(Restoration::kAmalgam)).ok());
}

}  // namespace
}  // namespace enamel::scoring
