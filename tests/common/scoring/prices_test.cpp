#include "common/scoring/mistakes/prices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/scene/builtin/rubrics.h"
#include "common/scene/price_kinds.h"
#include "common/scoring/mistakes/mistakes.h"

namespace enamel::scoring {
namespace {

using scene::RubricPrice;

RubricPrice Wall() { return {"wall", 0.4, 0.6, 12, 36, 2, 12, "a test"}; }

TEST(PriceOfTest, IsZeroAtZeroAndRisesToItsBoundWithoutReachingIt) {
  const RubricPrice p = Wall();
  EXPECT_EQ(PriceOf(p, 0, p.over), 0);
  EXPECT_EQ(PriceOf(p, -1, p.over), 0);
  double last = 0;
  for (int i = 1; i < 400; ++i) {
    const double price = PriceOf(p, 0.01 * i, p.over);
    EXPECT_GT(price, last) << i;
    EXPECT_LT(price, p.most) << i;
    last = price;
  }
  EXPECT_NEAR(PriceOf(p, 1e6, p.over), p.most, 1e-9);
}

TEST(PriceOfTest, AtItsSizeItCostsThePointsDampedByTheBound) {
  const RubricPrice p = Wall();
  // 12 / sqrt(1 + (12 / 36)^2)
  EXPECT_NEAR(PriceOf(p, 0.4, 0.4), 12 * 3 / std::sqrt(10.0), 1e-12);
  EXPECT_NEAR(PriceOf(p, 0.6, 0.6), PriceOf(p, 0.4, 0.4), 1e-12);
  // A small fault pays by its size alone: 12 points a size.
  EXPECT_NEAR(PriceOf(p, 0.004, 0.4) / 0.12, 1, 1e-5);
  // Where the line would reach the bound: 36 / sqrt 2.
  EXPECT_NEAR(PriceOf(p, 1.2, 0.4), 36 / std::sqrt(2.0), 1e-12);
}

TEST(PriceOfTest, EveryKindOfRegionAndTheContactNeedTheirPrice) {
  size_t needed = 0;
  for (const scene::PriceKind& kind : scene::kPriceKinds) needed += kind.is_needed;
  EXPECT_EQ(needed, kRegionKinds + 1);
  EXPECT_TRUE(scene::FindPriceKind(whole::kContact)->is_needed);
  for (size_t i = 0; i < kRegionKinds; ++i) {
    const scene::PriceKind* kind = scene::FindPriceKind(NameOf(static_cast<RegionKind>(i)));
    EXPECT_TRUE(kind != nullptr && kind->is_needed) << i;
  }
  for (const auto of : {whole::kElsewhere, whole::kNeighbour, whole::kPulp, whole::kCaries}) {
    EXPECT_NE(scene::FindPriceKind(of), nullptr) << of;
  }
}

// The figures that rubrics.cpp states: an even layer, of which the first 0.1 mm are the leeway.
TEST(PriceOfTest, BuiltInWallsAndFloorsCostWhatTheirCommentSays) {
  auto cost = [](const char* of, double thick_mm) {
    const auto prices = scene::PricesOfCavity();
    const auto price = std::ranges::find(prices, of, &RubricPrice::of);
    return PriceOf(*price, thick_mm - 0.1, price->over);
  };
  EXPECT_NEAR(cost("wall", 0.3), 5.3, 0.05);
  EXPECT_NEAR(cost("floor", 0.3), 6.2, 0.05);
  EXPECT_NEAR(cost("wall", 1), 20, 0.5);
  EXPECT_NEAR(cost("floor", 1), 23, 0.5);
}

std::vector<RubricPrice> Prices() {
  return {Wall(),
          {"floor", 0.4, 0.5, 10, 30, 2, 10, "a test"},
          {"elsewhere", 1, 0, 12, 60, 2, 12, "a test"}};
}

Result<CutCost> Cost(std::vector<RegionMeasure> measures) { return CostOf(measures, Prices()); }

TEST(CostOfTest, EachRegionPaysItsDearerSideOnceAndStatesFollowThePoints) {
  const auto cost = Cost({{"wall_mesial", "wall", 0.2, 0.2},
                          {"wall_distal", "wall", 0.1, 2},
                          {"floor", "floor", 0, 0}});
  ASSERT_TRUE(cost.ok());
  ASSERT_EQ(cost->rows.size(), 3U);
  EXPECT_TRUE(cost->rows[0].over) << "0.2 of 0.4 is dearer than 0.2 of 0.6";
  EXPECT_NEAR(cost->rows[0].lost, 6 / std::sqrt(1 + 1.0 / 36), 1e-12);
  EXPECT_EQ(cost->rows[0].state, State::kModify);
  EXPECT_FALSE(cost->rows[1].over);
  EXPECT_NEAR(cost->rows[1].lost, 40 / std::sqrt(1 + 100.0 / 81), 1e-12);
  EXPECT_EQ(cost->rows[1].state, State::kRedo);
  EXPECT_EQ(cost->rows[2].lost, 0);
  EXPECT_EQ(cost->rows[2].state, State::kAcceptable);
  EXPECT_NEAR(cost->sum, cost->rows[0].lost + cost->rows[1].lost, 1e-12);
}

TEST(CostOfTest, ALargerMeasureNeverEarnsPoints) {
  double last = 0;
  for (int i = 0; i < 100; ++i) {
    const double at = 0.02 * i;
    const auto cost = Cost({{"wall_mesial", "wall", at, 0.5},
                            {"floor", "floor", 0.1, at},
                            {"elsewhere", "elsewhere", at, 0},
                            {"not_done", "not_done", 0, 0.5 * i}});
    ASSERT_TRUE(cost.ok());
    EXPECT_GE(cost->sum, last) << i;
    last = cost->sum;
  }
}

// Of a task that was not begun at all a hundred points are lost, however little its regions pay.
TEST(CostOfTest, WhatWasNotDonePaysWhatItsRegionsDoNot) {
  const auto lost = [](double percent, double left_mm) {
    const auto cost =
        Cost({{"wall_mesial", "wall", 0, left_mm}, {"not_done", "not_done", 0, percent}});
    EXPECT_TRUE(cost.ok());
    return *cost;
  };
  EXPECT_EQ(lost(0, 0).sum, 0);
  EXPECT_NEAR(lost(50, 0).sum, 50, 1e-12);
  EXPECT_NEAR(lost(25, 0).sum, 10.3515625, 1e-12) << "t^3 (10 - 15 t + 6 t^2)";
  EXPECT_NEAR(lost(100, 0).sum, 100, 1e-12);
  const CutCost both = lost(50, 0.6);
  EXPECT_NEAR(both.sum, 50, 1e-12);
  EXPECT_NEAR(both.rows[1].lost, 50 - both.rows[0].lost, 1e-12);
  EXPECT_EQ(lost(10, 5).rows[1].lost, 0) << "the wall pays more";
}

TEST(CostOfTest, AKindOfRegionWithoutAPriceIsRefusedAndDamageWithoutOneIsFree) {
  const auto refused = Cost({{"axial_mesial", "axial_wall", 0.1, 0}});
  EXPECT_EQ(refused.status().code(), Code::kInvalidInput);
  EXPECT_EQ(refused.status().field(), "prices");
  EXPECT_NE(refused.status().message().find("axial_wall"), std::string::npos);
  const auto free = Cost({{"pulp", "pulp", 3, 0}, {"caries", "caries", 0, 50}});
  ASSERT_TRUE(free.ok());
  EXPECT_EQ(free->sum, 0);
}

TEST(UnitOfTest, EveryKindHasOne) {
  for (size_t i = 0; i < kRegionKinds; ++i)
    EXPECT_EQ(UnitOf(NameOf(static_cast<RegionKind>(i))), "mm");
  EXPECT_EQ(UnitOf("neighbour"), "mm");
  EXPECT_EQ(UnitOf("elsewhere"), "mm3");
  EXPECT_EQ(UnitOf("pulp"), "mm3");
  EXPECT_EQ(UnitOf("caries"), "%");
  EXPECT_EQ(UnitOf("not_done"), "%");
  EXPECT_EQ(UnitOf("beauty"), "");
}

TEST(GroupOfTest, EveryKindBelongsToOneGroup) {
  EXPECT_EQ(GroupOf("wall"), Group::kOutline);
  for (const char* kind :
       {"floor", "table", "axial_wall", "face", "line_angle", "caries", "not_done"})
    EXPECT_EQ(GroupOf(kind), Group::kInternalForm) << kind;
  EXPECT_EQ(GroupOf("margin"), Group::kMargins);
  for (const char* kind : {"elsewhere", "neighbour", "pulp"})
    EXPECT_EQ(GroupOf(kind), Group::kTissuePreserved) << kind;
}

TEST(ValidatePricesTest, RefusesWhatIsNoPriceAndNamesIt) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  struct Case {
    const char* field;
    std::function<void(std::vector<RubricPrice>&)> spoil;
  };
  const Case cases[] = {
      {"prices[0].of", [](auto& p) { p[0].of = "beauty"; }},
      {"prices[0].of", [](auto& p) { p[0].of = "not_done"; }},
      {"prices[1].of", [](auto& p) { p[1].of = "wall"; }},
      {"prices[0].over", [](auto& p) { p[0].over = 0; }},
      {"prices[0].over", [](auto& p) { p[0].left = 0; }},
      {"prices[0].over", [](auto& p) { p[0].over = kNan; }},
      {"prices[0].over", [](auto& p) { p[0].left = kInfinite; }},
      {"prices[0].over", [](auto& p) { p[0].over = 0.61; }},
      {"prices[2].over", [](auto& p) { p[2].left = 1; }},
      {"prices[0].points", [](auto& p) { p[0].points = 0; }},
      {"prices[0].points", [](auto& p) { p[0].points = kNan; }},
      {"prices[0].most", [](auto& p) { p[0].most = 11; }},
      {"prices[0].most", [](auto& p) { p[0].most = kInfinite; }},
      {"prices[0].redo_points", [](auto& p) { p[0].redo_points = p[0].modify_points; }},
      {"prices[0].redo_points", [](auto& p) { p[0].modify_points = 0; }},
      {"prices[0].redo_points", [](auto& p) { p[0].redo_points = kNan; }},
  };
  EXPECT_TRUE(ValidatePrices(Prices(), "prices").ok());
  for (const Case& c : cases) {
    std::vector<RubricPrice> prices = Prices();
    c.spoil(prices);
    const Status status = ValidatePrices(prices, "prices");
    EXPECT_EQ(status.code(), Code::kInvalidInput) << c.field;
    EXPECT_EQ(status.field(), c.field) << status.message();
  }
}

}  // namespace
}  // namespace enamel::scoring
