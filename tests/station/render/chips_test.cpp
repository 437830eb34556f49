#include "station/render/chips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "station/render/materials.h"

namespace enamel::station::render {
namespace {

using cutting::Tissue;

constexpr float kChipFrame_s = 1.0f / 60;
const cutting::Bur kChipBur{cutting::BurShape::kCylinder, 0.6e-3, 4e-3};
const cutting::Pose kChipPose{{1e-3, 2e-3, 3e-3}, {}};

std::array<double, cutting::kTissueCount> Removed(Tissue tissue, double mm3) {
  std::array<double, cutting::kTissueCount> out{};
  out[static_cast<size_t>(tissue)] = mm3;
  return out;
}

auto Alive(const Chips& chips) { return std::ranges::count_if(chips.all(), &Chip::alive); }

TEST(ChipsTest, WhereNothingIsRemovedNothingFlies) {
  Chips chips;
  chips.Add({}, kChipBur, kChipPose, kChipFrame_s);
  EXPECT_EQ(Alive(chips), 0);
  chips.Add(Removed(Tissue::kEnamel, -1), kChipBur, kChipPose, kChipFrame_s);
  EXPECT_EQ(Alive(chips), 0);
  // It is soft.
  chips.Add(Removed(Tissue::kPulp, 1), kChipBur, kChipPose, kChipFrame_s);
  EXPECT_EQ(Alive(chips), 0);
}

TEST(ChipsTest, AreAsManyAsWhatIsRemovedAsksForHoweverOftenItIsDrawn) {
  for (const int pictures : {1, 7, 100}) {
    Chips chips;
    for (int i = 0; i < pictures; ++i) {
      chips.Add(Removed(Tissue::kDentin, 40.5 / Chips::kPerMm3 / pictures), kChipBur, kChipPose, 0);
    }
    EXPECT_EQ(Alive(chips), 40) << pictures;
  }
}

// The cut that kPerMm3 names.
TEST(ChipsTest, AFullCutNearlyReachesTheBound) {
  Chips chips;
  for (int i = 0; i < 120; ++i) {
    chips.Step(kChipFrame_s);
    chips.Add(Removed(Tissue::kEnamel, 1.2 * 5 * 0.2 * static_cast<double>(kChipFrame_s)), kChipBur,
              kChipPose, kChipFrame_s);
  }
  EXPECT_GT(Alive(chips), 140);
  EXPECT_LT(Alive(chips), static_cast<int>(Chips::kMost));
}

TEST(ChipsTest, BeyondTheBoundEachTissueKeepsItsShare) {
  Chips chips;
  auto removed = Removed(Tissue::kEnamel, 30);
  removed[static_cast<size_t>(Tissue::kCaries)] = 10;
  chips.Add(removed, kChipBur, kChipPose, 0);
  EXPECT_NEAR(static_cast<double>(Alive(chips)), static_cast<double>(Chips::kMost), 1);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(chips.all(), Tissue::kCaries, &Chip::tissue)),
              Chips::kMost / 4.0, 1);
  for (int i = 0; i < 10; ++i) chips.Add(removed, kChipBur, kChipPose, 0);
  EXPECT_LE(Alive(chips), static_cast<int>(Chips::kMost));
}

TEST(ChipsTest, LeaveTheBurRiseFallShrinkAndAreGoneAfterAThirdOfASecond) {
  Chips chips;
  chips.Add(Removed(Tissue::kEnamel, 0.2), kChipBur, kChipPose, 0);
  ASSERT_EQ(Alive(chips), 100);
  const dvec3 tip_mm = kChipPose.tip_m * 1000.0;
  for (const Chip& chip : chips.all().first(100)) {
    const dvec3 from = dvec3(chip.at_mm) - tip_mm;
    EXPECT_NEAR(std::hypot(from.x, from.y), 0.6, 1e-3);
    EXPECT_GE(from.z, 0);
    EXPECT_LE(from.z, 1.2);
    EXPECT_GT(chip.mm_per_s.z, 0);
    EXPECT_LE(chip.radius_mm(), Chips::kWidest_mm);
  }
  float size_mm = 1;
  for (int i = 0; i < 19; ++i) {
    chips.Step(kChipFrame_s);
    const Chip& first = chips.all().front();
    EXPECT_TRUE(first.radius_mm() < size_mm || !first.alive());
    size_mm = first.radius_mm();
    for (const Chip& chip : chips.all().first(100)) {
      // Within the picture of a crown, 8 mm.
      EXPECT_LT(glm::distance(dvec3(chip.at_mm), tip_mm), 8);
      EXPECT_TRUE(i < 17 || !chip.alive() || chip.mm_per_s.z < 0) << "falls by then";
    }
  }
  chips.Step(2 * kChipFrame_s);
  EXPECT_EQ(Alive(chips), 0);
  Shape shape;
  ShapeOf(chips.all(), shape);
  EXPECT_TRUE(shape.vertices.empty());
}

TEST(ChipsTest, HaveTheColourOfWhatWasCut) {
  for (const Tissue tissue : {Tissue::kEnamel, Tissue::kDentin, Tissue::kCaries}) {
    Chips chips;
    chips.Add(Removed(tissue, 0.02), kChipBur, kChipPose, 0);
    Shape shape;
    ShapeOf(chips.all(), shape);
    ASSERT_EQ(shape.vertices.size(), 40u);
    EXPECT_EQ(shape.indices.size(), 120u);
    for (const GpuVertex& vertex : shape.vertices) {
      EXPECT_EQ(vertex.tissue, kTooth);
      EXPECT_EQ(vertex.look, LookOf(dvec3(TissueColour(tissue)), kCutGloss * TissueGloss(tissue)));
    }
  }
}

TEST(ChipsTest, TheSameCutsGiveTheSameGrains) {
  Chips one, other;
  for (int i = 0; i < 30; ++i) {
    for (Chips* chips : {&one, &other}) {
      chips->Step(kChipFrame_s);
      chips->Add(Removed(Tissue::kDentin, 0.01), kChipBur, kChipPose, kChipFrame_s);
    }
  }
  EXPECT_TRUE(std::ranges::equal(one.all(), other.all(), {}, &Chip::at_mm, &Chip::at_mm));
}

}  // namespace
}  // namespace enamel::station::render
