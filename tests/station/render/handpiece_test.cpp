#include "station/render/handpiece.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <random>

namespace enamel::station::render {
namespace {

constexpr float kHeight_mm = 4;  // of the bur's cutting part

glm::vec3 At(const Shape& shape, uint32_t index) {
  const float* p = shape.vertices[index].position_mm;
  return {p[0], p[1], p[2]};
}

// The segment meets a triangle of the body (Möller and Trumbore 1997).
bool Meets(const Shape& shape, const glm::vec3& from, const glm::vec3& to) {
  const glm::vec3 way = to - from;
  for (size_t i = 0; i + 2 < shape.indices.size(); i += 3) {
    const glm::vec3 a = At(shape, shape.indices[i]), e1 = At(shape, shape.indices[i + 1]) - a,
                    e2 = At(shape, shape.indices[i + 2]) - a, h = glm::cross(way, e2);
    const float det = glm::dot(e1, h);
    if (std::fabs(det) < 1e-9f) continue;
    const glm::vec3 s = from - a, q = glm::cross(s, e1);
    const float u = glm::dot(s, h) / det, v = glm::dot(way, q) / det, t = glm::dot(e2, q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t <= 1) return true;
  }
  return false;
}

// Where the handle points in the scene.
glm::vec3 Handle(const Quat& scene_from_bur, const Camera& camera) {
  const float a = HandleAzimuth(scene_from_bur, camera);
  return glm::vec3(scene_from_bur.Matrix() * dvec3(std::cos(a), std::sin(a), 0));
}

Quat Turn(const dvec3& axis, double angle) {
  const dvec3 v = glm::normalize(axis) * std::sin(angle / 2);
  return {v.x, v.y, v.z, std::cos(angle / 2)};
}

TEST(HandpieceTest, HasTheDimensionsThatItsHeaderStates) {
  const Shape shape = HandpieceShape(kHeight_mm);
  const float low = HeadFrom_mm(kHeight_mm);
  EXPECT_GT(low, kHeight_mm + 4) << "neck and shank of the bur are seen";
  float lowest = 1e9f, highest = 0, behind = 0, farthest = 0;
  glm::vec3 end(0);
  for (uint32_t i = 0; i < shape.vertices.size(); ++i) {
    const glm::vec3 p = At(shape, i);
    lowest = std::min(lowest, p.z);
    behind = std::max(behind, -p.x);
    if (std::hypot(p.x, p.y) < kHeadRadius_mm + 0.01f && std::fabs(p.x) < 1)
      highest = std::max(highest, p.z);
    if (p.x > farthest) farthest = p.x, end = p;
  }
  EXPECT_FLOAT_EQ(lowest, low);
  EXPECT_NEAR(highest - low, kHeadHeight_mm, 1e-3);
  EXPECT_NEAR(behind, kHeadRadius_mm, 1e-3);
  const glm::vec3 out = end - glm::vec3(0, 0, low + kHeadHeight_mm / 2);
  EXPECT_NEAR(glm::length(out), kHandpieceLength_mm - kHeadRadius_mm, 1);
  const float off_axis = glm::degrees(std::asin(kHandleEndRadius_mm / glm::length(out)));
  const float to_bur = glm::degrees(std::acos(-out.z / glm::length(out)));
  EXPECT_NEAR(to_bur, kHandleAngle_deg, off_axis + 0.1f);
}

// The body's own triangles judge what it hides.
TEST(HandpieceTest, WhereItHidesTheBursTipItIsGlass) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  int hidden = 0, opaque = 0;
  for (const float height_mm : {1.0f, 4.0f, 8.0f}) {
    const Shape shape = HandpieceShape(height_mm);
    for (int i = 0; i < 400; ++i) {
      const glm::vec3 eye = 80.0f * glm::normalize(glm::vec3(unit(random), unit(random),
                                                             0.1f + std::fabs(unit(random))));
      const float opacity = HandpieceOpacity(height_mm, eye);
      EXPECT_TRUE(opacity >= kGlass && opacity <= 1);
      opaque += opacity == 1 ? 1 : 0;
      if (!Meets(shape, {0, 0, 0}, eye)) continue;
      ++hidden;
      EXPECT_FLOAT_EQ(opacity, kGlass) << eye.x << " " << eye.y << " " << eye.z;
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(opaque, 100);
}

TEST(HandpieceTest, TurnsToGlassWithoutAJump) {
  float before = 1;
  for (int i = 0; i <= 900; ++i) {
    const float a = glm::radians(0.1f * static_cast<float>(i));  // from the side to right above
    const float now = HandpieceOpacity(kHeight_mm, 60.0f * glm::vec3(-std::cos(a), 0, std::sin(a)));
    EXPECT_LE(now, before + 1e-6f) << i;
    EXPECT_GE(now, before - 0.05f) << i;
    before = now;
  }
  EXPECT_FLOAT_EQ(before, kGlass);
}

TEST(HandpieceTest, TheHandleLeavesThePictureAtTheHandsSideHoweverTheBurLeans) {
  for (const float aside : {0.2f, -0.2f}) {
    Camera camera(glm::vec3(0), 8, aside);
    camera.SetView(View::kOblique);
    for (int i = 0; i < 12; ++i) {
      camera.Orbit(0.07f, 0.01f);
      for (const double lean : {0.0, 0.3, 0.7}) {
        const dvec3 axis(std::cos(i), std::sin(i), 0);
        const glm::vec3 handle = Handle(Turn(axis, lean), camera);
        EXPECT_GT(camera.free_side() * glm::dot(handle, camera.Right()), 0.6f) << i << " " << lean;
      }
    }
  }
}

TEST(HandpieceTest, WhatTheHandTurnsAboutTheBursAxisTurnsTheHandle) {
  const Camera camera(glm::vec3(0), 8);
  for (const double lean : {0.0, 0.4}) {
    const Quat leans = Turn({1, 2, 0}, lean);
    const dvec3 axis = leans.Matrix()[2];
    const dvec3 still(Handle(leans, camera));
    for (const double angle : {-1.2, 0.5, 2.5}) {
      const dvec3 turned(Handle(leans * Turn({0, 0, 1}, angle), camera));
      const double found =
          std::atan2(glm::dot(axis, glm::cross(still, turned)), glm::dot(still, turned));
      EXPECT_NEAR(found, angle, 1e-5);
    }
  }
}

}  // namespace
}  // namespace enamel::station::render
