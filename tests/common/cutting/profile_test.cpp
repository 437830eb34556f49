#include "common/cutting/profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/cutting/burs.h"

namespace enamel::cutting {
namespace {

// The outline as a fine polygon in the (r, z) plane, from each shape's definition alone.
std::vector<glm::dvec2> Polygon(const Bur& b) {
  std::vector<glm::dvec2> out;
  auto arc = [&](glm::dvec2 c, double radius, double from, double to) {
    for (int i = 0; i <= 20000; ++i) {
      double t = from + (to - from) * i / 20000;
      out.push_back(c + radius * glm::dvec2(std::cos(t), std::sin(t)));
    }
  };
  double r = b.radius_m, s = b.narrow_radius_m, l = b.length_m;
  switch (b.shape) {
    case BurShape::kSphere:
      arc({0, r}, r, -M_PI / 2, M_PI / 2);
      return out;
    case BurShape::kCylinder:
      out = {{0, 0}, {r, 0}, {r, l}, {0, l}};
      return out;
    case BurShape::kCone:
      out = {{0, 0}, {s, 0}, {r, l}, {0, l}};
      return out;
    case BurShape::kInvertedCone:
      out = {{0, 0}, {r, 0}, {s, l}, {0, l}};
      return out;
    case BurShape::kWheel:
      out = {{0, 0}};
      arc({r - l / 2, l / 2}, l / 2, -M_PI / 2, M_PI / 2);
      out.push_back({0, l});
      return out;
    case BurShape::kPear: {
      // The tangent from (s, l) to the ball: its touching point's angle.
      glm::dvec2 q(s, l - r);
      arc({0, r}, r, -M_PI / 2, std::atan2(q.y, q.x) - std::acos(r / glm::length(q)));
      out.push_back({s, l});
      out.push_back({0, l});
      return out;
    }
    case BurShape::kFlame: {
      // Circle through (0, 0) and (s, l) whose largest r is the bur's: bisection for its height.
      double lo = l / 2, hi = l;
      auto miss = [&](double zm) {
        double rc = (r * r - zm * zm) / (2 * r);
        return std::hypot(s - rc, l - zm) - (r - rc);
      };
      for (int i = 0; i < 200; ++i) {
        double mid = (lo + hi) / 2;
        (miss(lo) > 0) == (miss(mid) > 0) ? lo = mid : hi = mid;
      }
      double rc = (r * r - lo * lo) / (2 * r), big = r - rc;
      arc({rc, lo}, big, std::atan2(-lo, -rc), std::atan2(l - lo, s - rc));
      out.push_back({0, l});
      return out;
    }
  }
  return out;
}

double PolygonDistance(const std::vector<glm::dvec2>& p, glm::dvec2 at) {
  double best = 1e9;
  bool inside = false;
  for (size_t i = 0; i < p.size(); ++i) {
    glm::dvec2 a = p[i], b = p[(i + 1) % p.size()], d = b - a;
    // The last edge runs along the axis: no surface.
    if (i + 1 < p.size() && glm::dot(d, d) > 0) {
      double t = std::clamp(glm::dot(at - a, d) / glm::dot(d, d), 0.0, 1.0);
      best = std::min(best, glm::length(at - a - t * d));
    }
    if ((a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * d.x)
      inside = !inside;
  }
  return inside ? -best : best;
}

TEST(ProfileTest, DistanceOfEveryShapeIsThatToItsOutlineDrawnAsAPolygon) {
  for (const Bur& bur : test::AllBurs()) {
    ASSERT_FALSE(WhyImpossible(bur)) << *WhyImpossible(bur);
    auto polygon = Polygon(bur);
    double height = bur.height_m(), r = bur.radius_m;
    for (int i = 0; i <= 12; ++i) {
      for (int k = 0; k <= 30; ++k) {
        glm::dvec2 p(1e-9 + 1.8 * r * i / 12, -0.6 * r + (height + 1.2 * r) * (k + 0.37) / 31);
        ASSERT_NEAR(ProfileOf(bur).Distance(p.x, p.y), PolygonDistance(polygon, p), 2e-12)
            << BurShapeName(bur.shape) << " at r " << p.x << " z " << p.y;
      }
    }
  }
}

TEST(ProfileTest, BurDistanceIsTheClosedFormOfACylinderOnEverySide) {
  Bur bur{BurShape::kCylinder, 1, 4};
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(3, 0, 2)), 2);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, -1)), 1);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(4, 0, 8)), 5);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, 2)), -1);
  EXPECT_DOUBLE_EQ(bur.Distance(dvec3(0, 0, 0.25)), -0.25);
}

TEST(ProfileTest, SurfacePointsLieOnTheSurfaceAndCarryItsWholeArea) {
  for (const Bur& bur : test::AllBurs()) {
    auto polygon = Polygon(bur);
    double exact = 0;
    for (size_t i = 0; i + 1 < polygon.size(); ++i) {
      exact += M_PI * (polygon[i].x + polygon[i + 1].x) * glm::length(polygon[i + 1] - polygon[i]);
    }
    double area = 0;
    for (const SurfacePoint& p : SampleSurface(bur, 0.15e-3, 320)) {
      EXPECT_NEAR(bur.Distance(p.position_m), 0, 1e-12) << BurShapeName(bur.shape);
      EXPECT_NEAR(glm::length(p.normal), 1, 1e-14);
      // The normal is the way in which the distance grows.
      EXPECT_NEAR(bur.Distance(p.position_m + 1e-6 * p.normal), 1e-6, 1e-12)
          << BurShapeName(bur.shape);
      area += p.area_m2;
    }
    EXPECT_NEAR(area / exact, 1, 1e-7) << BurShapeName(bur.shape);
  }
}

TEST(ProfileTest, ImpossibleProportionsAreNamed) {
  EXPECT_TRUE(WhyImpossible({BurShape::kCone, 0.5e-3, 2e-3, 0.6e-3}));
  EXPECT_TRUE(WhyImpossible({BurShape::kInvertedCone, 0.5e-3, 2e-3, 0}));
  EXPECT_TRUE(WhyImpossible({BurShape::kPear, 0.5e-3, 0.9e-3, 0.2e-3}));
  EXPECT_TRUE(WhyImpossible({BurShape::kFlame, 0.5e-3, 4e-3, 0.5e-3}));
  EXPECT_TRUE(WhyImpossible({BurShape::kWheel, 0.5e-3, 2e-3}));
  EXPECT_TRUE(WhyImpossible({BurShape::kSphere, 0}));
}

}  // namespace
}  // namespace enamel::cutting
