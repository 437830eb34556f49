#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/cutting/voxel_limit.h"
#include "common/scoring/mistakes/acceptable_cut.h"
#include "common/trace/replay.h"
#include "station/lab/cutting/attempt.h"
#include "station/lab/cutting/cutting_error.h"
#include "station/lab/cutting/order.h"

// The benchmarks measure what they name. No test here depends on a time.
namespace enamel::station::lab {
namespace {

CuttingPlan Plan(std::vector<CutCase> cases, std::vector<int32_t> voxels_nm) {
  CuttingPlan plan;
  plan.cases = std::move(cases);
  plan.voxels_nm = std::move(voxels_nm);
  plan.ticks = 100;
  plan.replays = 1;
  plan.grids = 1;
  return plan;
}

TEST(TickCostTest, BurIsEngagedInEveryMeasuredTickAndReplaysAgree) {
  for (Sunk sunk : {Sunk::kHalf, Sunk::kWhole, Sunk::kLying}) {
    CutCase c;
    c.voxel_nm = 100'000;
    c.sunk = sunk;
    TickCost cost = TimeTicks(MakeCutPath(c, 200), 2);
    EXPECT_EQ(cost.ticks, 200u);
    EXPECT_EQ(cost.engaged_share, 1) << SunkName(sunk);
    EXPECT_TRUE(cost.replays_agree);
  }
}

// 5 mm/s for 0.2 s is 1 mm of a slot 1.2 mm wide: 2 mm deep upright, 0.6 mm deep and 4 mm wide
// lying.
TEST(TickCostTest, RemovesWhatTheWayIsLong) {
  CutCase c;
  c.voxel_nm = 50'000;
  EXPECT_NEAR(TimeTicks(MakeCutPath(c, 200), 1).removed_mm3, 1.2 * 2 * 1, 0.02 * 2.4);
  c.sunk = Sunk::kLying;
  EXPECT_NEAR(TimeTicks(MakeCutPath(c, 200), 1).removed_mm3, 0.6 * 4 * 1, 0.02 * 2.4);
}

TEST(TickCostTest, SpreadIsMeanAndNinetyNinthPercentile) {
  std::vector<double> values;
  for (int i = 1; i <= 1000; ++i) values.push_back(i);
  Spread spread = SpreadOf(values);
  EXPECT_DOUBLE_EQ(spread.mean, 500.5);
  EXPECT_DOUBLE_EQ(spread.p99, 991);
  EXPECT_EQ(SpreadOf({}).mean, 0);
}

// The integral over the outline is compared with closed forms of the shapes that have one.
TEST(CuttingErrorTest, SweptVolumeMeetsTheClosedForms) {
  CutCase cylinder, ball;
  cylinder.oblique = ball.oblique = true;
  ball.bur = {cutting::BurShape::kSphere, 0.5e-3, 0};
  auto figures = MeasureCutting(Plan({cylinder, ball}, {100'000}));
  ASSERT_EQ(figures.size(), 2u);
  // The anchor ends at X: 0.3 s of settling and 0.1 s measured at 5 mm/s after the entry.
  double x = 1.1 + 0.4 * 5, r = 0.6, depth = 2;
  EXPECT_NEAR(figures[0].grids[0].analytic_mm3,
              (2 * r * x + 0.5 * std::numbers::pi * r * r) * depth, 0.02);
  // Half a ball of radius R: 2 X times its half disc, and half of half its volume.
  x = 1.0 + 0.4 * 5;
  r = 0.5;
  EXPECT_NEAR(figures[1].grids[0].analytic_mm3,
              2 * x * 0.25 * std::numbers::pi * r * r + std::numbers::pi * r * r * r / 3, 0.02);
}

// A cylinder and a ball that plunge: pi r^2 of depth, the ball's end a half ball.
TEST(CuttingErrorTest, PlungedVolumeMeetsTheClosedForms) {
  CutCase cylinder, ball;
  ball.bur = {cutting::BurShape::kSphere, 0.5e-3, 0};
  for (CutCase* c : {&cylinder, &ball}) c->oblique = c->plunge = true;
  auto figures = MeasureCutting(Plan({cylinder, ball}, {100'000}));
  double r = 0.6, depth = 4 + 0.4 * 5;
  EXPECT_NEAR(figures[0].grids[0].analytic_mm3, std::numbers::pi * r * r * depth, 0.03);
  r = 0.5, depth = 1 + 0.4 * 5;
  EXPECT_NEAR(figures[1].grids[0].analytic_mm3, std::numbers::pi * r * r * (depth - r / 3), 0.03);
}

TEST(CuttingErrorTest, EveryBurIsWithinAPercentOfItsSweptVolumeAndAVoxelOfItsSurface) {
  auto plan = Plan(BurCases(), {100'000});
  for (CutCase& c : plan.cases) c.oblique = true;
  auto figures = MeasureCutting(plan);
  ASSERT_EQ(figures.size(), 7u);
  for (const CuttingFigures& f : figures) {
    const CutErrors& e = f.grids[0];
    EXPECT_LT(std::fabs(e.volume), 0.01) << BurText(f.c.bur);
    EXPECT_GT(e.vertices, 100u) << BurText(f.c.bur);
    EXPECT_LT(e.surface_p95_um, 100) << BurText(f.c.bur);
    EXPECT_LT(e.surface_mean_um, e.surface_p95_um) << BurText(f.c.bur);
    EXPECT_LT(e.force, 0.15) << BurText(f.c.bur);
  }
}

// Tissue pushes the ball up by a micrometre; the reference goes where the ball was.
TEST(CuttingErrorTest, HalfTheVoxelHalvesTheErrorsOfABall) {
  CutCase ball;
  ball.bur = {cutting::BurShape::kSphere, 0.5e-3, 0};
  ball.oblique = true;
  auto plan = Plan({ball}, {100'000, 50'000});
  plan.grids = 8;
  auto figures = MeasureCutting(plan);
  ASSERT_EQ(figures.size(), 2u);
  std::vector<double> volume[2], surface[2];
  for (size_t i = 0; i < 2; ++i) {
    for (const CutErrors& e : figures[i].grids) {
      volume[i].push_back(e.volume);
      surface[i].push_back(e.surface_p95_um);
    }
  }
  EXPECT_GT(OrderOf(volume[0], volume[1]).low, kFalls);
  EXPECT_GT(OrderOf(surface[0], surface[1]).low, kFalls);
}

TEST(OrderTest, IsTheExponentOfAnErrorThatChangesItsSign) {
  const double coarse[] = {4, -4, 3, -5}, fine[] = {-1, 1, 0.75, 1.25};
  ObservedOrder o = OrderOf(coarse, fine);
  EXPECT_DOUBLE_EQ(o.order, 2);
  EXPECT_LT(o.low, 2);
  EXPECT_GT(o.high, 2);
}

TEST(OrderTest, IndexIsNoNumberOutsideItsAsymptoticRange) {
  auto second = IndexOf({1 + 0.64, 1 + 0.16, 1 + 0.04, 1 + 0.01});
  EXPECT_TRUE(second.asymptotic);
  EXPECT_NEAR(second.order, 2, 1e-9);
  EXPECT_NEAR(second.index, 1.25 * 0.01, 1e-9);  // 0.01 is what is left
  for (auto values : {std::array{1.0, 2.0, 1.5, 1.6}, std::array{1.0, 1.1, 1.2, 1.21},
                      std::array{1.0, 1.0, 1.0, 1.0}}) {
    auto none = IndexOf(values);
    EXPECT_FALSE(none.asymptotic);
    EXPECT_TRUE(std::isnan(none.index));
  }
}

AttemptOptions ShortAttempt() {
  AttemptOptions options;
  options.voxel_nm = 100'000;
  options.ticks = 20'000;
  return options;
}

TEST(AttemptTest, IsARecordingThatReplaysTickByTick) {
  auto attempt = RecordAttempt(ShortAttempt());
  ASSERT_TRUE(attempt.ok()) << attempt.status().message();
  EXPECT_EQ(attempt->seal.ticks, 20'000u);
  EXPECT_GT(attempt->cutting_share, 0.15);
  EXPECT_LT(attempt->cutting_share, 0.6);
  core::Core core(attempt->header.params, attempt->built.volume);
  auto report = trace::Replay(core, attempt->header, attempt->chunks);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(report->witness_ok) << report->what;
  EXPECT_EQ(report->state_hash, attempt->seal.state_hash);
}

// To a voxel, here the coarsest.
TEST(AttemptTest, WallsCutTooDeepOnPurposeAreScoredAsThat) {
  auto scores = MeasureScores({100'000}, 60'000);
  ASSERT_TRUE(scores.ok()) << scores.status().message();
  const auto& regions = scores->at(0).regions;
  auto over = [&](const char* name) {
    const auto found = std::ranges::find(regions, name, &RegionFigures::region);
    EXPECT_NE(found, regions.end()) << name;
    return found == regions.end() ? -1 : found->over;
  };
  EXPECT_NEAR(over("wall_mesial"), (kMesialExtra_m - scoring::kLeeway_m) * 1e3, 0.1);
  EXPECT_NEAR(over("floor"), (kFloorExtra_m - scoring::kLeeway_m) * 1e3, 0.1);
  EXPECT_LT(over("wall_distal"), 0.1);
}

}  // namespace
}  // namespace enamel::station::lab
