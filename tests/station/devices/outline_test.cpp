#include "station/devices/outline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enamel::station {
namespace {

using PartOutline = scene::PreparationPart::Outline;

scene::PreparationPart Disc(int32_t radius_um) {
  scene::PreparationPart part;
  part.outline = PartOutline::kDisc;
  part.half_size_um = {radius_um, radius_um};
  part.depth_um = 1'000;
  return part;
}

double Area(const Outline& o) {
  double twice = 0;
  for (size_t i = 0; i < o.size(); ++i) {
    const auto &a = o[i], &b = o[(i + 1) % o.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * twice;
}

TEST(OutlineTest, ADiscIsWithinSeventeenMicrometresOfItsCircle) {
  const Outline o = OutlineOf(Disc(2'000));
  EXPECT_TRUE(IsConvex(o));
  EXPECT_NEAR(Inradius(o), 2e-3, 1e-9);
  for (const auto& p : o) {
    EXPECT_LE(std::sqrt(p.x * p.x + p.y * p.y), 2.018e-3);
  }
}

TEST(OutlineTest, ARectangleMovesToTheLastBitAsItsNumbersDo) {
  const Outline o = RectangleOf({-1.1e-3, 2.3e-3, -0.7e-3, 0.9e-3});
  const Bounds in = BoundsOf(Grown(o, -0.3e-3));
  EXPECT_EQ(in.x0, -1.1e-3 + 0.3e-3);
  EXPECT_EQ(in.x1, 2.3e-3 - 0.3e-3);
  EXPECT_EQ(in.y0, -0.7e-3 + 0.3e-3);
  EXPECT_EQ(in.y1, 0.9e-3 - 0.3e-3);
  EXPECT_TRUE(Grown(o, -0.9e-3).empty());
}

TEST(OutlineTest, SidesThatShrinkAwayGoAndTheOthersStayWhereTheyAre) {
  // A square without one corner: 1 mm in, that corner is a square's again.
  const Outline o = {{0, 0}, {4e-3, 0}, {4e-3, 3.8e-3}, {3.8e-3, 4e-3}, {0, 4e-3}};
  const Outline in = Grown(o, -1e-3);
  ASSERT_EQ(in.size(), 4u);
  EXPECT_NEAR(Area(in), 4e-6, 1e-12);
}

TEST(OutlineTest, ADiscMovedByOneSideMoreKeepsItsOtherSide) {
  // Like a person who cuts one wall too far: the more a side faces mesially, the farther.
  const Outline o = Moved(OutlineOf(Disc(2'500)), [](const glm::dvec2& out) {
    return 0.2e-3 * std::max(out.x, 0.0) - 0.15e-3 * std::max(-out.x, 0.0);
  });
  ASSERT_TRUE(IsConvex(o));
  const Bounds b = BoundsOf(o);
  EXPECT_NEAR(b.x1, 2.7e-3, 0.03e-3);
  EXPECT_NEAR(b.x0, -2.35e-3, 0.03e-3);
  EXPECT_NEAR(b.y1, 2.5e-3, 0.03e-3);
  EXPECT_GT(Inradius(o), 2.35e-3);
}

TEST(OutlineTest, WithinCutsOffWhatLiesBeyond) {
  const Outline o = Within(OutlineOf(Disc(2'000)), {-5e-3, 1e-3, -5e-3, 5e-3});
  EXPECT_NEAR(BoundsOf(o).x1, 1e-3, 1e-12);
  EXPECT_TRUE(IsConvex(o));
}

}  // namespace
}  // namespace enamel::station
