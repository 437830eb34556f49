#include "common/scoring/tolerances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "common/scoring/score.h"

namespace enamel::scoring {
namespace {

using scene::Restoration;
using scene::Rubric;
using scene::RubricPrice;

RubricPrice Wall(double over, double left) { return {"wall", over, left, 12, 36, 2, 12, "a test"}; }

// Composite forgives walls and a contact, ceramic is stricter with walls and prices caries too.
Rubric FilledCavity(Restoration restoration) {
  Rubric r;
  r.name = "cavity";
  r.prices = {Wall(0.4, 0.6), {"floor", 0.4, 0.6, 14, 42, 2, 14, "a test"}};
  r.critical = {{"contact_left", "contact_left_percent", "%", 25, true, "a test"}};
  r.restoration = restoration;
  r.restorations = {{Restoration::kAmalgam, "a test", {}, {}},
                    {Restoration::kComposite,
                     "a test",
                     {Wall(0.8, 0.8)},
                     {{"contact_left", "contact_left_percent", 50}}},
                    {Restoration::kCeramic,
                     "a test",
                     {Wall(0.2, 0.2), {"caries", 0, 100, 120, 600, 6, 24, "a test"}},
                     {}}};
  return r;
}

struct Faults {
  double wall_over = 0, floor_left = 0, caries_left = 0, contact = 0;
};
ScoreResult ScoreFor(const Rubric& rubric, const Faults& cut) {
  auto result = ApplyRubric(rubric, {{{"contact_left_percent", cut.contact, "%"}}, {}},
                            {{"wall_mesial", "wall", cut.wall_over, 0},
                             {"floor", "floor", 0, cut.floor_left},
                             {"caries", "caries", 0, cut.caries_left}});
  EXPECT_TRUE(result.ok()) << result.status().message();
  return result.ok() ? *result : ScoreResult{};
}
double PointsFor(Restoration restoration, const Faults& cut) {
  return ScoreFor(FilledCavity(restoration), cut).points;
}

// Of 12 points a size and 36 at most.
double WallCosts(double sizes) { return 12 * sizes / std::sqrt(1 + sizes * sizes / 9); }

TEST(TolerancesTest, AMaterialsPriceCountsInPlaceOfTheRubrics) {
  const Faults wide{.wall_over = 0.4};
  EXPECT_NEAR(PointsFor(Restoration::kNone, wide), 100 - WallCosts(1), 1e-9);
  EXPECT_NEAR(PointsFor(Restoration::kComposite, wide), 100 - WallCosts(0.5), 1e-9);
  EXPECT_NEAR(PointsFor(Restoration::kCeramic, wide), 100 - WallCosts(2), 1e-9);
  // Every other part costs what the rubric asks.
  const Faults shallow{.floor_left = 0.3};
  EXPECT_EQ(PointsFor(Restoration::kCeramic, shallow), PointsFor(Restoration::kNone, shallow));
}

TEST(TolerancesTest, AMaterialMayPriceWhatTheRubricDoesNot) {
  const Faults soft{.caries_left = 1};
  EXPECT_EQ(PointsFor(Restoration::kNone, soft), 100);
  EXPECT_NEAR(PointsFor(Restoration::kCeramic, soft), 98.8, 1e-4);
}

TEST(TolerancesTest, AMaterialWithoutPricesKeepsTheRubrics) {
  const Faults cut{.wall_over = 0.3, .floor_left = 0.2, .contact = 40};
  EXPECT_EQ(ScoreFor(FilledCavity(Restoration::kAmalgam), cut),
            ScoreFor(FilledCavity(Restoration::kNone), cut));
}

TEST(TolerancesTest, AContactThatAmalgamNeedsOpenMayBeLeftUnderComposite) {
  const auto fails = [](Restoration restoration, double percent) {
    return ScoreFor(FilledCavity(restoration), {.contact = percent}).critical_fail;
  };
  EXPECT_TRUE(fails(Restoration::kNone, 40));
  EXPECT_TRUE(fails(Restoration::kAmalgam, 40));
  EXPECT_FALSE(fails(Restoration::kComposite, 40));
  EXPECT_TRUE(fails(Restoration::kComposite, 60));
}

TEST(TolerancesTest, ARubricThatNamesNoMaterialIsAsWithoutTolerances) {
  Rubric without = FilledCavity(Restoration::kNone);
  EXPECT_EQ(WithTolerances(without), without);
  without.restorations.clear();
  const Faults cut{.wall_over = 0.3, .caries_left = 20};
  EXPECT_EQ(ScoreFor(without, cut), ScoreFor(FilledCavity(Restoration::kNone), cut));
}

TEST(TolerancesTest, RefusesAMaterialWithoutTolerancesAndTolerancesForNothing) {
  struct Case {
    const char* field;
    const char* said;
    std::function<void(Rubric&)> spoil;
  };
  const Case cases[] = {
      {"restoration", "no tolerances for amalgam", [](Rubric& r) { r.restorations.clear(); }},
      {"restorations[1].restoration", "amalgam has tolerances already",
       [](Rubric& r) { r.restorations[1].restoration = Restoration::kAmalgam; }},
      {"restorations[1].restoration", "expected a material",
       [](Rubric& r) { r.restorations[1].restoration = Restoration::kNone; }},
      {"restorations[1].prices[0].of", "beauty",
       [](Rubric& r) { r.restorations[1].prices[0].of = "beauty"; }},
      {"restorations[2].prices[1].of", "already",
       [](Rubric& r) { r.restorations[2].prices[1] = r.restorations[2].prices[0]; }},
      {"restorations[1].critical[0].error", "no critical error",
       [](Rubric& r) { r.restorations[1].critical[0].error = "all_cut"; }},
      {"restorations[1].critical[0].error", "finite",
       [](Rubric& r) { r.restorations[1].critical[0].limit = 0.0 / 0.0; }},
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
