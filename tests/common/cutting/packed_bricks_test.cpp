#include "common/cutting/packed_bricks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/support/analytic_volume.h"

namespace enamel::cutting {
namespace {

struct Filling {
  std::string name;
  std::function<int(int x, int y, int z)> phi;
};

int Clamped(double phi) {
  return static_cast<int>(std::lround(std::clamp(phi, -1.0 * kPhiLimit, 1.0 * kPhiLimit)));
}

std::vector<Filling> Fillings() {
  std::vector<Filling> out;
  for (int limit : {-kPhiLimit, 0, int{kPhiLimit}})
    out.push_back({"all " + std::to_string(limit), [=](int, int, int) { return limit; }});
  // The farthest that a sample can be from what is predicted, in every direction.
  out.push_back(
      {"chequered", [](int x, int y, int z) { return (x + y + z) % 2 ? kPhiLimit : -kPhiLimit; }});
  // A surface through the brick from every side: it comes back from the limit in some.
  for (int side = 0; side < 27; ++side) {
    const dvec3 to(side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1);
    out.push_back({"plane " + std::to_string(side), [=](int x, int y, int z) {
                     return Clamped(1.3 * kPhiPerVoxel * (Dot(to, dvec3(x, y, z) - 3.5) + 2));
                   }});
    out.push_back({"ball " + std::to_string(side), [=](int x, int y, int z) {
                     return Clamped(kPhiPerVoxel * (glm::length(dvec3(x, y, z) - 20.0 * to) - 22));
                   }});
  }
  for (double noise : {0.5, 100.0, 5000.0}) {
    out.push_back({"noise " + std::to_string(noise),
                   [=, random = std::mt19937(7)](int x, int y, int z) mutable {
                     std::normal_distribution<double> off(0, noise);
                     return Clamped(kPhiPerVoxel * (x + 0.3 * y - 0.7 * z - 2) + off(random));
                   }});
  }
  out.push_back({"random", [random = std::mt19937(11)](int, int, int) mutable {
                   return std::uniform_int_distribution<int>(-kPhiLimit, kPhiLimit)(random);
                 }});
  return out;
}

BrickPhi BrickOf(const Filling& c) {
  BrickPhi out;
  for (int i = 0; i < kBrickVoxels; ++i)
    out.phi[static_cast<size_t>(i)] = static_cast<int16_t>(c.phi(i & 7, i >> 3 & 7, i >> 6));
  return out;
}

BrickLabels LabelsOf(unsigned seed, int tissues) {
  std::mt19937 random(seed);
  BrickLabels out;
  for (auto& t : out.tissue)
    t = static_cast<uint8_t>(std::uniform_int_distribution<int>(0, tissues - 1)(random));
  return out;
}

// All in one, unpacked in another order: none leans on another's bytes.
TEST(PackedBricksTest, WhatComesOutIsWhatWentIn) {
  const std::vector<Filling> fillings = Fillings();
  std::vector<BrickPhi> bricks;
  PackedBricks packed;
  auto labels = [](size_t i) { return LabelsOf(static_cast<unsigned>(i), i % 2 ? 2 : 8); };
  for (size_t i = 0; i < fillings.size(); ++i) {
    bricks.push_back(BrickOf(fillings[i]));
    const BrickLabels l = labels(i);
    packed.Append(bricks.back(), i % 3 ? &l : nullptr, static_cast<Tissue>(i % kTissueCount));
  }
  packed.ShrinkToFit();
  ASSERT_EQ(packed.size(), fillings.size());
  for (size_t n = fillings.size(); n-- > 0;) {
    BrickPhi phi;
    BrickLabels l;
    packed.Unpack(n, phi, &l);
    EXPECT_EQ(phi.phi, bricks[n].phi) << fillings[n].name;
    EXPECT_EQ(packed.tissue(n), static_cast<Tissue>(n % kTissueCount));
    ASSERT_EQ(packed.has_labels(n), n % 3 != 0);
    if (n % 3) EXPECT_EQ(l.tissue, labels(n).tissue) << fillings[n].name;
  }
}

size_t BytesOf(const BrickPhi& phi) {
  PackedBricks packed;
  packed.Append(phi, nullptr, Tissue::kEnamel);
  packed.ShrinkToFit();
  return packed.MemoryBytes();
}

// A face at one corner of a brick, the rest of which is at the limit. The order of its samples begins there, whichever
// corner it is. From the wrong one it takes twice the bytes.
TEST(PackedBricksTest, ASurfaceCostsTheSameWhicheverWayItFaces) {
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 to(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Filling face{"", [=](int x, int y, int z) {
                         const dvec3 p = dvec3(x, y, z) - 3.5 + 10.0 * to;
                         return Clamped(kPhiPerVoxel * (23 - glm::length(p)));
                       }};
    EXPECT_LE(BytesOf(BrickOf(face)), 200u) << corner;
  }
}

Volume PackedBall() {
  const GridSpec spec{100'000, ivec3(5), {-2'000'000, -2'000'000, -2'000'000}};
  return test::VolumeOf(spec, Tissue::kDentin,
                        [&](const dvec3& p) { return glm::length(p) - 1.3e-3; });
}

TEST(PackedVolumeTest, IsTheSameTooth) {
  const Volume ball = PackedBall(), packed = ball.Packed();
  // Half of it are bricks that hold the surface and the whole band.
  EXPECT_LT(packed.MemoryBytes(), 0.3 * static_cast<double>(ball.MemoryBytes()));
  EXPECT_TRUE(packed == ball);
  EXPECT_TRUE(packed.Unpacked() == ball);
  EXPECT_TRUE(packed.Packed() == ball);
  for (int b = 0; b < ball.spec().brick_count(); ++b) {
    ASSERT_EQ(packed.IsStored(b), ball.IsStored(b));
    ASSERT_EQ(packed.UniformTissue(b), ball.UniformTissue(b));
    ASSERT_EQ(packed.Lowest(b), ball.Lowest(b));
  }
}

// Around every point of a walk that leaves the grid, all that a read there may ask for is unpacked.
TEST(PackedVolumeTest, DistancesAroundAPointAreThoseOfTheUnpackedTooth) {
  const Volume ball = PackedBall();
  Volume packed = ball.Packed();
  packed.Reserve();
  const double n = ball.spec().voxels().x;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-12, n + 12), off(-1.5, 1.5);
  for (int i = 0; i < 3000; ++i) {
    const dvec3 g(at(random), at(random), at(random));
    if (i % 3 == 0) packed.Warm();
    packed.UnpackAround(g);
    const dvec3 near = g + dvec3(off(random), off(random), off(random));
    ASSERT_EQ(packed.DistanceAtSample(near), ball.DistanceAtSample(near));
    dvec3 one, other;
    ASSERT_EQ(packed.DistanceAndSlope(near, 9, one), ball.DistanceAndSlope(near, 9, other));
    ASSERT_EQ(one, other);
  }
  packed.UnpackAround({std::nan(""), 0, 0});
  EXPECT_TRUE(packed == ball);
}

TEST(PackedVolumeDeathTest, ReadingWhatIsPackedEndsTheProgram) {
  const Volume packed = PackedBall().Packed();
  int brick = 0;
  while (!packed.IsPacked(brick)) ++brick;
  EXPECT_DEATH((void)packed.Phi(brick), "CHECK failed");
  EXPECT_DEATH((void)packed.Samples(brick), "CHECK failed");
}

}  // namespace
}  // namespace enamel::cutting
