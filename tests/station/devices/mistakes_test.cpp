#include "station/devices/mistakes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enamel::station {
namespace {

constexpr uint64_t kSeeds = 200;

double Largest_m(const SideErrors& e) {
  return std::max({std::fabs(e.mesial_m), std::fabs(e.distal_m), std::fabs(e.buccal_m),
                   std::fabs(e.lingual_m), std::fabs(e.floor_m)});
}
double Least_m(const SideErrors& e) {
  return std::min({std::fabs(e.mesial_m), std::fabs(e.distal_m), std::fabs(e.buccal_m),
                   std::fabs(e.lingual_m), std::fabs(e.floor_m)});
}

TEST(MistakesTest, AFullySkilledHandMakesNone) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Mistakes m = MistakesOf(0, seed);
    EXPECT_EQ(Largest_m(m.sides), 0);
    EXPECT_EQ(m.lean_deg, 0);
    EXPECT_EQ(m.speed_ratio, 1);
    EXPECT_EQ(m.push_ratio, 1);
    EXPECT_EQ(m.tremor_ratio, 1);
    EXPECT_FALSE(m.gouge || m.done_last);
  }
}

TEST(MistakesTest, EachRankLacksAQuarterLessThanTheOneBelow) {
  EXPECT_EQ(LackAt(1), 1);
  for (int rank = 2; rank < kFullSkill; ++rank)
    EXPECT_NEAR(LackAt(rank), 0.75 * LackAt(rank - 1), 1e-12) << rank;
  EXPECT_EQ(LackAt(kFullSkill), 0);
  EXPECT_EQ(LackAt(0), 0) << "a hand made for one fault makes no other";
}

TEST(MistakesTest, TheSameSeedDrawsTheSameBits) {
  const Mistakes m = MistakesOf(0.5, 101), again = MistakesOf(0.5, 101), other = MistakesOf(0.5, 7);
  EXPECT_EQ(m.sides.mesial_m, again.sides.mesial_m);
  EXPECT_EQ(m.sides.floor_m, again.sides.floor_m);
  EXPECT_EQ(m.lean_deg, again.lean_deg);
  EXPECT_EQ(m.gouge.has_value(), again.gouge.has_value());
  EXPECT_NE(m.sides.mesial_m, other.sides.mesial_m);
}

// No side is right, and none is farther off than the largest mistake.
TEST(MistakesTest, EveryoneWhoLacksSkillErrsOnEverySide) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SideErrors sides = MistakesOf(0.5, seed).sides;
    EXPECT_GE(Least_m(sides), 0.5 * 0.24e-3);
    EXPECT_LE(Largest_m(sides), 0.5 * 0.45e-3 * 1.5 + 1e-12);
  }
}

TEST(MistakesTest, LessSkillErrsMoreInTheSameKinds) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    Mistakes better = MistakesOf(0.1, seed);
    for (const double lack : {0.3, 0.5, 0.7, 0.9, 1.0}) {
      const Mistakes worse = MistakesOf(lack, seed);
      EXPECT_GT(Least_m(worse.sides), Least_m(better.sides));
      EXPECT_GT(Largest_m(worse.sides), Largest_m(better.sides));
      EXPECT_GT(worse.tremor_ratio, better.tremor_ratio);
      EXPECT_TRUE(worse.gouge || !better.gouge);
      if (better.gouge) EXPECT_GT(worse.gouge->deep_m, better.gouge->deep_m);
      EXPECT_TRUE(worse.done_last || !better.done_last);
      better = worse;
    }
  }
}

TEST(MistakesTest, EveryKindIsMade) {
  constexpr double kLack = 0.3;  // one mistake
  size_t over = 0, left = 0, tilted = 0, gouged = 0, disordered = 0;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Mistakes m = MistakesOf(kLack, seed);
    const double side = Largest_m(m.sides);
    const bool one_side = side > kLack * 0.48e-3;
    const double most = std::max(
        {m.sides.mesial_m, m.sides.distal_m, m.sides.buccal_m, m.sides.lingual_m, m.sides.floor_m});
    over += one_side && most == side;
    left += one_side && most != side;
    tilted += std::fabs(m.lean_deg) > kLack * 2;
    gouged += m.gouge.has_value();
    disordered += m.done_last.has_value();
  }
  for (const size_t made : {over, left, tilted, gouged, disordered}) EXPECT_GT(made, kSeeds / 10);
}

Stroke Round(double z_m) {
  Stroke s;
  s.points = {{0, 0, z_m}, {1e-3, 0, z_m}, {1e-3, 1e-3, z_m}, {0, 0, z_m}};
  return s;
}

TEST(MistakesTest, AStepIsDoneLastWithAirOnTheWayAndNoneIsLost) {
  constexpr double kClear_m = 5e-3;
  std::vector<Move> plan;
  for (int i = 0; i < 8; ++i) plan.emplace_back(Round(-1e-3 * i));
  const auto out = OutOfOrder(plan, 0, kClear_m);
  ASSERT_EQ(out.size(), plan.size() + 3);
  const auto& gap = std::get<Stroke>(out[1]);
  EXPECT_FALSE(gap.bur_on);
  for (const dvec3& p : gap.points) EXPECT_EQ(p.z, kClear_m);
  EXPECT_FALSE(std::get<Stroke>(out[8]).bur_on);
  EXPECT_EQ(std::get<Stroke>(out[9]).points, std::get<Stroke>(plan[1]).points);
  EXPECT_EQ(std::get<Stroke>(out[10]).points.back().z, kClear_m);
}

TEST(MistakesTest, APlanWithoutAStepToMoveStaysAsItIs) {
  EXPECT_TRUE(OutOfOrder({}, 0.5, 1e-3).empty());
  EXPECT_EQ(OutOfOrder({Move(Round(0)), Move(Round(1e-3))}, 0.5, 2e-3).size(), 2u);
}

}  // namespace
}  // namespace enamel::station
