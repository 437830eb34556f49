#include "station/render/tooth_looks.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <glm/exponential.hpp>
#include <iterator>
#include <string>

#include "common/scene/builder.h"
#include "station/render/materials.h"
#include "tests/support/analytic_volume.h"

namespace enamel::station::render {
namespace {

using cutting::GridSpec;
using cutting::Tissue;
using cutting::Volume;

constexpr double kVoxel_m = 50e-6;

// A block, all of it solid, with a tissue for each point (mm).
Volume Block(const ivec3& bricks, const std::function<Tissue(const dvec3&)>& tissue_at) {
  Volume volume(GridSpec{50'000, bricks, {}});
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    const ivec3 first = cutting::kBrickSide *
                        ivec3(b % bricks.x, b / bricks.x % bricks.y, b / (bricks.x * bricks.y));
    std::array<int16_t, cutting::kBrickVoxels> deep;
    deep.fill(-cutting::kPhiLimit);
    std::array<uint8_t, cutting::kBrickVoxels> labels;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const ivec3 voxel = first + ivec3(i % 8, i / 8 % 8, i / 64);
      labels[static_cast<size_t>(i)] =
          static_cast<uint8_t>(tissue_at(1e3 * kVoxel_m * dvec3(voxel)));
    }
    volume.SetBrick(b, deep, labels, static_cast<Tissue>(labels[0]));
  }
  return volume;
}

dvec3 AlbedoOf(const Look& look) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    const double root = look.root_albedo[static_cast<size_t>(i)] / 255.0;
    out[i] = root * root;
  }
  return out;
}

// A step of dentin under enamel: 0.25 mm of enamel on one half, 1.2 mm on the other.
TEST(ToothLooksTest, DentinShowsThroughEnamelTheMoreTheThinnerItIs) {
  constexpr double kTop_mm = 2.375;
  const Volume volume = Block({12, 8, 6}, [&](const dvec3& p) {
    return kTop_mm - p.z < (p.x < 2.4 ? 0.25 : 1.2) ? Tissue::kEnamel : Tissue::kDentin;
  });
  const ToothLooks looks(volume);
  auto enamel_at = [&](double x_mm) {
    const Look look = looks.At(1e-3 * dvec3(x_mm, 1.6, kTop_mm), {0, 0, 1}, Tissue::kEnamel);
    const double enamel = TissueColour(Tissue::kEnamel).b, dentin = TissueColour(Tissue::kDentin).b;
    return (AlbedoOf(look).b - dentin) / (enamel - dentin);
  };
  // 1 - 1 / (1 + S t)^2 with S = 1.58 per mm, within half a voxel of t, which is 1.15 times as long for
  // the four of five ways that are aslant.
  EXPECT_NEAR(enamel_at(1.4), 0.52, 0.04);
  EXPECT_NEAR(enamel_at(3.4), 0.90, 0.02);
}

// CIE L*a*b* of linear sRGB.
dvec3 Lab(const dvec3& c) {
  auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = f((0.4124 * c.r + 0.3576 * c.g + 0.1805 * c.b) / 0.9505),
               y = f(0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b),
               z = f((0.0193 * c.r + 0.1192 * c.g + 0.9505 * c.b) / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

TEST(ToothLooksTest, AMillimetreOfEnamelIsAsTranslucentAndOpalescentAsMeasured) {
  const dvec3 thick = TissueColour(Tissue::kEnamel), back = EnamelOverDark(1e-3);
  // S t from the share x / (1 + x) that comes back; then over a white ground of 0.9.
  const dvec3 x = back / (1.0 - back), white = (0.1 * x + 0.9) / (0.1 * x + 1.0);
  // 15 to 19 in reviews of it (Lee, Restor. Dent. Endod. 41, 2016, 159-166).
  EXPECT_NEAR(glm::length(Lab(thick * white) - Lab(thick * back)), 17, 2);
  const dvec3 apart = Lab(1.0 - back) - Lab(back);
  EXPECT_NEAR(std::hypot(apart.y, apart.z), 22.9, 3);
}

TEST(ToothLooksTest, AnEdgeWithoutDentinIsDarkerAndBluish) {
  // A slab of enamel, 1 mm thick at first; beside it dentin inside.
  const Volume volume = Block({6, 12, 16}, [](const dvec3& p) {
    return p.z < 3 && p.x > 0.7 && p.x < 1.7 ? Tissue::kDentin : Tissue::kEnamel;
  });
  const ToothLooks looks(volume);
  auto at = [&](double z_mm) {
    return AlbedoOf(looks.At({2.375e-3, 2.4e-3, 1e-3 * z_mm}, {1, 0, 0}, Tissue::kEnamel));
  };
  const dvec3 edge = at(5), body = at(1.2);
  EXPECT_LT(edge.r, 0.95 * body.r);
  EXPECT_GT(edge.b / edge.r, 1.1 * body.b / body.r);
}

// Surfaces of a field, of enamel, around the origin.
class GrooveTest : public testing::Test {
 protected:
  using Field = std::function<double(const dvec3&)>;
  static Volume Of(const Field& field_m) {
    GridSpec spec{50'000, ivec3(8), {-1'600'000, -1'610'000, -1'590'000}};
    return test::VolumeOf(spec, Tissue::kEnamel, field_m);
  }
  // The planes fall toward a line, or away from it, at 35 degrees.
  static double Valley(const dvec3& p) { return std::min(Slope(p, 1), Slope(p, -1)); }
  static double Ridge(const dvec3& p) { return std::max(Slope(p, -1), Slope(p, 1)); }
  static double Slope(const dvec3& p, double side) {
    return (p.z - side * 0.7 * p.x) / std::hypot(1, 0.7);
  }
  static double Light(const ToothLooks& looks, double x_m, double z_m) {
    return AlbedoOf(looks.At({x_m, 0, z_m}, {0, 0, 1}, Tissue::kEnamel)).r;
  }
};

// A slab of 1 mm that a bur has left of one of 1.7 mm: light falls on both sides of it.
TEST_F(GrooveTest, AWallThatWasCutIsNoEdgeBeforeTheMouthsDark) {
  auto slab = [](double to_m) {
    return [to_m](const dvec3& p) { return std::max(-0.5e-3 - p.x, p.x - to_m); };
  };
  const Volume wall = Of(slab(0.5e-3)), before = Of(slab(1.2e-3));
  auto light = [](const ToothLooks& looks, double side) {
    return AlbedoOf(looks.At({side * 0.5e-3, 0, 0}, {side, 0, 0}, Tissue::kEnamel)).b;
  };
  const double thick = TissueColour(Tissue::kEnamel).b;
  for (double side : {-1.0, 1.0}) {
    EXPECT_NEAR(light(ToothLooks(wall, &before), side), thick, 0.01) << side;
    EXPECT_LT(light(ToothLooks(wall), side), 0.9 * thick) << side;
  }
}

TEST_F(GrooveTest, ANarrowGrooveIsStainedAndWhatIsBesideItIsNot) {
  const Volume valley = Of(Valley), ridge = Of(Ridge);
  const ToothLooks in_valley(valley), on_ridge(ridge);
  const double clean = Light(in_valley, 0.6e-3, 0.42e-3);
  EXPECT_LT(Light(in_valley, 0, 0), 0.6 * clean);
  EXPECT_NEAR(Light(on_ridge, 0, 0), clean, 0.06);
}

TEST_F(GrooveTest, AWideHollowIsNotStained) {
  auto bowl = [](const dvec3& p) { return 2e-3 - glm::length(p - dvec3(0, 0, 2e-3)); };
  const Volume hollow = Of(bowl), plane = Of([](const dvec3&p) { return p.z; });
  EXPECT_NEAR(Light(ToothLooks(hollow), 0, 0), Light(ToothLooks(plane), 0, 0), 0.01);
}

TEST_F(GrooveTest, WhatABurCutsIsCleanAndMatt) {
  const Volume valley = Of(Valley), before = Of([](const dvec3&p) { return p.z - 0.5e-3; });
  const ToothLooks looks(valley, &before);
  EXPECT_NEAR(Light(looks, 0, 0), Light(looks, 0.6e-3, 0.42e-3), 0.06);
  const Look cut = looks.At(dvec3(0), {0, 0, 1}, Tissue::kEnamel),
             uncut = ToothLooks(before, &before).At({0, 0, 0.5e-3}, {0, 0, 1}, Tissue::kEnamel);
  EXPECT_LT(cut.gloss, 0.3 * uncut.gloss);
}

TEST_F(GrooveTest, TeethThatTouchAreNotStained) {
  GridSpec spec{50'000, ivec3(8), {-1'600'000, -1'610'000, -1'590'000}};
  const Volume touching = scene::BuildVolume(spec, [](const dvec3& p) {
    return scene::FieldSample{Valley(p), p.x < 0 ? Tissue::kNeighbour : Tissue::kEnamel, 0};
  });
  const ToothLooks looks(touching);
  EXPECT_GT(Light(looks, 0.03e-3, 0), 0.9 * Light(looks, 0.6e-3, 0.42e-3));
}

TEST(ToothLooksTest, ALesionGoesFromChalkWhiteToBrownWithoutAStep) {
  const Volume volume =
      Block({16, 8, 4}, [](const dvec3& p) { return p.x < 3 ? Tissue::kEnamel : Tissue::kCaries; });
  const ToothLooks looks(volume);
  auto at = [&](double x_mm) {
    const Tissue own = x_mm < 3 ? Tissue::kEnamel : Tissue::kCaries;
    return AlbedoOf(looks.At(1e-3 * dvec3(x_mm, 1.6, 1.575), {0, 0, 1}, own));
  };
  const dvec3 sound = at(2), edge = at(2.9), inner = at(3.1), core = at(4);
  EXPECT_GT(edge.b, sound.b) << "chalk";
  EXPECT_LT(inner.r, edge.r);
  EXPECT_NEAR(core.r, TissueColour(Tissue::kCaries).r, 0.01);
  // In a voxel; chalk and brown differ by 1.3.
  for (double x = 2.4; x < 3.6; x += 0.05) {
    EXPECT_LT(glm::length(at(x + 0.05) - at(x)), 0.65) << x;
  }
  EXPECT_LT(looks.At({4e-3, 1.6e-3, 1.575e-3}, {0, 0, 1}, Tissue::kCaries).gloss, 40);
}

// Under the middle of a block's top.
dvec3 TopWith(Tissue above, Tissue below, double thickness_mm) {
  constexpr double kTop_mm = 2.375;
  const Volume volume = Block(
      {12, 12, 6}, [&](const dvec3& p) { return kTop_mm - p.z < thickness_mm ? above : below; });
  return AlbedoOf(ToothLooks(volume).At(1e-3 * dvec3(2.4, 2.4, kTop_mm), {0, 0, 1}, above));
}

TEST(ToothLooksTest, ALesionThrowsAShadowThroughSoundEnamel) {
  const dvec3 over_dentin = TopWith(Tissue::kEnamel, Tissue::kDentin, 0.8),
              over_lesion = TopWith(Tissue::kEnamel, Tissue::kCaries, 0.8);
  EXPECT_LT(over_lesion.r, 0.93 * over_dentin.r);
}

TEST(ToothLooksTest, ThePulpShinesPinkThroughHalfAMillimetreOfDentin) {
  const dvec3 dentin = TissueColour(Tissue::kDentin);
  const dvec3 near = TopWith(Tissue::kDentin, Tissue::kPulp, 0.5),
              far = TopWith(Tissue::kDentin, Tissue::kPulp, 1.5);
  EXPECT_GT(near.r / near.g, 1.15 * dentin.r / dentin.g);
  EXPECT_NEAR(far.r, dentin.r, 0.01);
  EXPECT_NEAR(far.g, dentin.g, 0.01);
}

// The page draws with the same colours (web/src/tooth/scene/stain.test.ts).
TEST(ToothLooksTest, ColoursAndGroovesAreThoseOfThePage) {
  auto hex = [](const glm::vec3& linear) {
    const glm::ivec3 c(glm::round(glm::pow(linear, glm::vec3(1 / 2.2f)) * 255.0f));
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", c.r, c.g, c.b);
    return std::string(text);
  };
  std::string found;
  for (const Tissue tissue : {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCaries}) {
    found += std::string(cutting::TissueName(tissue)) + " " + hex(TissueColour(tissue)) + "\n";
  }
  found += "stain " + hex(StainColour()) + "\n";
  char numbers[120];
  std::snprintf(numbers, sizeof numbers,
                "groove_from_per_mm %g\ngroove_full_per_mm %g\nmost_stained %g\n",
                1e-3 * kGrooveFrom_per_m, 1e-3 * kGrooveFull_per_m, kMaxStained);
  std::ifstream file(std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/tooth_look.txt");
  EXPECT_EQ(found + numbers, std::string(std::istreambuf_iterator<char>(file), {}));
}

}  // namespace
}  // namespace enamel::station::render
