#include "common/scoring/envelope.h"

#include <gtest/gtest.h>

#include "common/scoring/score.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

constexpr int32_t kVoxel_nm = 100'000;
constexpr double kVoxel_mm = kVoxel_nm * 1e-6, kMm3 = 1e9;

// Cuts with poses half a voxel apart leave scallops on the floor, others for each wall.
constexpr double kScallops_mm3 = 0.001;

// The default cavity with the mesial wall farther out.
Cavity Wider(double mesial_mm) {
  Cavity out;
  out.mesial_mm += mesial_mm;
  return out;
}
// Area of the mesial wall: what moves when it does. The turning cylinder rounds the corners, which
// move along.
double WallArea_mm2() {
  const Cavity c;
  return (c.buccal_mm + c.lingual_mm) * c.depth_mm;
}

MetricSet Said(double wall_mm, bool with_caries = false) {
  MetricSet out;
  out.values.push_back({"wall_mesial_mm", wall_mm, "mm"});
  if (with_caries) out.values.push_back({"caries_left_mm3", 1, "mm3"});
  return out;
}

class EnvelopeTest : public testing::Test {
 protected:
  // Dentists at these walls; metrics as said.
  Result<Envelope> Place(const Volume& attempt, double wall_mm,
                         const std::vector<double>& dentists_mm) {
    std::vector<Volume> cuts;
    for (double at_mm : dentists_mm) cuts.push_back(CutCavity(block_, Wider(at_mm)));
    std::vector<EnvelopeMember> members;
    for (size_t r = 0; r < cuts.size(); ++r) {
      members.push_back({"dentist " + std::to_string(r), &cuts[r], Said(dentists_mm[r])});
    }
    return PlaceInEnvelope(block_, attempt, Said(wall_mm, true), members);
  }

  const Volume block_ = MakeBlock(kVoxel_nm);
};

TEST_F(EnvelopeTest, VolumesAreThoseOfTheLayersBetweenTheWalls) {
  const Volume attempt = CutCavity(block_, Wider(0.5));
  auto placed = Place(attempt, 0.5, {0, 0.1, 0.3});
  ASSERT_TRUE(placed.ok()) << placed.status().message();
  const double near = WallArea_mm2() * kVoxel_mm / 4;
  EXPECT_NEAR(placed->disputed_m3 * kMm3, 0.3 * WallArea_mm2(), near);
  EXPECT_LT(placed->left_of_all_m3 * kMm3, kScallops_mm3);
  // Its removal shared with nobody, with the widest, with two, with all three.
  ASSERT_EQ(placed->taken_by_m3.size(), 4u);
  EXPECT_NEAR(placed->taken_by_m3[0] * kMm3, 0.2 * WallArea_mm2(), near);
  EXPECT_NEAR(placed->taken_by_m3[1] * kMm3, 0.2 * WallArea_mm2(), near);
  EXPECT_NEAR(placed->taken_by_m3[2] * kMm3, 0.1 * WallArea_mm2(), near);
  double taken = 0;
  for (double m3 : placed->taken_by_m3) taken += m3;
  const auto before = cutting::SolidVolume_m3(block_), after = cutting::SolidVolume_m3(attempt);
  double gone = 0;
  for (size_t t = 0; t < before.size(); ++t) gone += before[t] - after[t];
  EXPECT_NEAR(taken, gone, 1e-6 * gone) << "each voxel counts once";
}

TEST_F(EnvelopeTest, WhatEveryDentistTookAndTheAttemptLeftIsSaid) {
  const Volume attempt = CutCavity(block_, Wider(-0.2));
  auto placed = Place(attempt, -0.2, {0, 0.1});
  ASSERT_TRUE(placed.ok());
  EXPECT_NEAR(placed->left_of_all_m3 * kMm3, 0.2 * WallArea_mm2(), WallArea_mm2() * kVoxel_mm / 4);
  EXPECT_LT(placed->taken_by_m3[0] * kMm3, kScallops_mm3);
}

TEST_F(EnvelopeTest, NearestDentistIsFirst) {
  const Volume attempt = CutCavity(block_, Wider(0.3));
  auto placed = Place(attempt, 0.3, {0, 0.3, 0.1});
  ASSERT_TRUE(placed.ok());
  ASSERT_EQ(placed->members.size(), 3u);
  EXPECT_EQ(placed->members[0], (EnvelopeOverlap{"dentist 1", 1.0})) << "the same cut";
  EXPECT_EQ(placed->members[1].attempt, "dentist 2");
  EXPECT_EQ(placed->members[2].attempt, "dentist 0");
  EXPECT_LT(placed->members[2].dice, placed->members[1].dice);
}

TEST_F(EnvelopeTest, MetricsHaveMedianSpreadAndPlace) {
  const Volume attempt = CutCavity(block_, Wider(0.3));
  auto placed = Place(attempt, 0.3, {0, 0.1, 0.3});
  ASSERT_TRUE(placed.ok());
  ASSERT_EQ(placed->metrics.size(), 1u) << "what a dentist has no value of is left out";
  const MetricPlace& wall = placed->metrics[0];
  EXPECT_EQ(wall.name, "wall_mesial_mm");
  EXPECT_EQ(wall.least, 0);
  EXPECT_EQ(wall.median, 0.1);
  EXPECT_EQ(wall.most, 0.3);
  EXPECT_NEAR(wall.spread, 0.14826, 1e-12);
  EXPECT_NEAR(*wall.z, 0.2 / 0.14826, 1e-12);
  EXPECT_NEAR(wall.percentile, 100 * 2.5 / 3, 1e-12);
}

TEST_F(EnvelopeTest, DentistsWhoAgreeGiveNoZ) {
  const Volume attempt = CutCavity(block_, Wider(0.3));
  auto placed = Place(attempt, 0.3, {0.1, 0.1});
  ASSERT_TRUE(placed.ok());
  EXPECT_FALSE(placed->metrics[0].z);
  EXPECT_EQ(placed->metrics[0].percentile, 100);
}

TEST_F(EnvelopeTest, UncutToothAmongDentistsTookNothing) {
  auto placed = Place(block_, 0, {0, 0.1});
  ASSERT_TRUE(placed.ok());
  for (double m3 : placed->taken_by_m3) EXPECT_EQ(m3, 0);
  EXPECT_GT(placed->left_of_all_m3, 0);
  EXPECT_EQ(placed->members[0].dice, 0);
}

TEST_F(EnvelopeTest, OneReferenceTooManyAndAnotherGridAreRefused) {
  const Volume attempt = CutCavity(block_, {});
  EXPECT_EQ(Place(attempt, 0, {0}).status().code(), Code::kInvalidInput);
  EXPECT_EQ(Place(attempt, 0, std::vector<double>(9, 0)).status().code(), Code::kInvalidInput);
  EXPECT_EQ(Place(MakeBlock(200'000), 0, {0, 0.1}).status().code(), Code::kInvalidInput);
}

TEST_F(EnvelopeTest, IsWrittenWithTheScoreAndReadBack) {
  auto placed = Place(CutCavity(block_, Wider(0.3)), 0.3, {0, 0.1, 0.3});
  ASSERT_TRUE(placed.ok());
  ScoreResult score;
  EXPECT_FALSE(ScoreFromJson(ToJson(score))->envelope) << "one reference: none";
  score.envelope = *placed;
  const std::string text = ToJson(score);
  auto read = ScoreFromJson(text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_TRUE(read->envelope);
  EXPECT_EQ(read->envelope->members.size(), 3u);
  EXPECT_EQ(read->envelope->metrics[0].name, "wall_mesial_mm");
  EXPECT_EQ(ToJson(*read), text);
}

}  // namespace
}  // namespace enamel::scoring
