#include "common/scene/builtin/drawn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"

// Exercises that are drawn: their documents, and whether a bur can leave what they draw.
namespace enamel::scene {
namespace {

constexpr int32_t kVoxel_nm = 200'000;

std::string Document(const std::string& corners, const std::string& like = "class-1",
                     const std::string& more = "") {
  return R"({"enamel_builtin_exercise": 1, "name": "n", "like": ")" + like +
         R"(", "scenes": ["molar-46"], "landmark": "occlusal_centre", "title": "T",
         "instructions": "I.", "source": "S.", )" +
         more + R"("parts": [{"corners_um": )" + corners + R"(, "depth_um": 1500}]})";
}

TEST(DrawnTest, EveryDocumentIsOfScenesThatThereAre) {
  std::set<std::string> scenes;
  for (const std::string& name : BuiltinSceneNames()) {
    scenes.insert(BuildBuiltinScene(name, 400'000)->scene.name);
  }
  for (const std::string_view text : DrawnDocuments()) {
    const auto drawn = DrawnFromJson(text);
    ASSERT_TRUE(drawn.ok()) << drawn.status().message();
    for (const std::string& scene : drawn->scenes) EXPECT_TRUE(scenes.contains(scene)) << scene;
  }
}

// A square of 4 mm with a radius of 1 mm: every corner lies on the circle about (1, 1) mm or its like, and no chord leaves
// it by more than two hundredths of the radius.
TEST(DrawnTest, CornersAreArcs) {
  const auto drawn = DrawnFromJson(Document(
      "[[-2000, -2000, 1000], [2000, -2000, 1000], [2000, 2000, 1000], [-2000, 2000, 1000]]"));
  ASSERT_TRUE(drawn.ok()) << drawn.status().message();
  const auto& corners = drawn->parts.at(0).corners_um;
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const auto off_um = [](double x, double y) {
      return std::hypot(std::fabs(x) - 1'000, std::fabs(y) - 1'000) - 1'000;
    };
    EXPECT_NEAR(off_um(a[0], a[1]), 0, 1);
    const bool straight = a[0] == b[0] || a[1] == b[1];
    if (!straight) {
      EXPECT_NEAR(off_um(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])), -10, 10);
    }
  }
  EXPECT_GE(corners.size(), 20U);
}

TEST(DrawnTest, WhatCannotBeDrawnIsRefusedWithItsPlace) {
  const std::string square = "[[0, 0, 0], [2000, 0, 0], [2000, 2000, 0], [0, 2000, 0]]";
  ASSERT_TRUE(DrawnFromJson(Document(square)).ok());
  const auto field = [](const std::string& text) { return DrawnFromJson(text).status().field(); };
  const std::string corners = "/parts/0/corners_um";
  EXPECT_EQ(field(Document("[[0, 0, 0], [2000, 0, 0]]")), corners);
  EXPECT_EQ(field(Document("[[0, 0, 0], [0, 2000, 0], [2000, 0, 0]]")), corners) << "clockwise";
  EXPECT_EQ(field(Document("[[0, 0, 0], [2000, 2000, 0], [2000, 0, 0], [0, 2000, 0]]")), corners);
  EXPECT_EQ(field(Document("[[0, 0, 1001], [2000, 0, 1001], [2000, 2000, 0], [0, 2000, 0]]")),
            corners)
      << "arcs longer than their side";
  EXPECT_EQ(field(Document("[[0, 0, -1], [2000, 0, 0], [2000, 2000, 0]]")), corners);
  EXPECT_EQ(field(Document("[[0, 0, 0], [0, 0, 0], [2000, 2000, 100]]")), corners);
  EXPECT_EQ(field(Document("[[0, 0, 100], [1000, 0, 100], [2000, 0, 100], [0, 2000, 0]]")), corners)
      << "an arc on a straight side";
  EXPECT_EQ(field(Document(square, "crown")), "/like");
  EXPECT_EQ(field(Document(square, "class-1", R"("colour": "red", )")), "/colour");
  EXPECT_EQ(DrawnFromJson("{").status().code(), Code::kInvalidInput);
}

std::vector<BuiltScene> ScenesWithDrawings() {
  std::vector<BuiltScene> out;
  for (const std::string& name : BuiltinSceneNames()) {
    auto built = BuildBuiltinScene(name, kVoxel_nm);
    if (!DrawnExercises(built->scene, {}).empty()) out.push_back(std::move(*built));
  }
  return out;
}

// A disc of the bur's radius covers every point of the task and sticks out of the task by at most 0.03 mm. Only points of
// the tooth count: beyond it a bur may go. A thousandth may be missed: at the outer corners of a box, 0.1 mm wide, an
// adjacent tooth keeps the bur inside, and a hand instrument breaks the enamel.
TEST(DrawnTest, ItsOwnBurLeavesEachOutline) {
  constexpr double kStep_m = 0.04e-3, kAllowed_m = 0.03e-3;
  for (const BuiltScene& built : ScenesWithDrawings()) {
    for (const Exercise& e : DrawnExercises(built.scene, {})) {
      SCOPED_TRACE(e.name);
      const auto shape = TargetShape(built.scene, e.target);
      ASSERT_TRUE(shape.ok());
      const double radius = e.bur_radius_um * 1e-6;
      // Half way down the shallowest part, where every part has walls.
      const auto shallowest =
          std::ranges::min_element(shape->parts, {}, &PreparationPart::depth_um);
      const double z = (shallowest->top_um[2] - 0.5 * shallowest->depth_um) * 1e-6;
      const PointUm& at = built.scene.landmarks.at(e.target.landmark);
      const dvec3 half = dvec3(e.target.half_size_um[0], e.target.half_size_um[1], 0) * 1e-6;
      std::vector<dvec3> middles, inside;
      for (double x = -half.x; x <= half.x; x += kStep_m)
        for (double y = -half.y; y <= half.y; y += kStep_m) {
          const dvec3 p(at[0] * 1e-6 + x, at[1] * 1e-6 + y, z);
          const double d = PreparationDistance_m(*shape, p);
          if (d <= kAllowed_m - radius) middles.push_back(p);
          // Points nearer to the border are left out: a grid of middles can miss them.
          if (d <= -0.5 * kStep_m && built.volume.DistanceAt_m(p) < 0) inside.push_back(p);
        }
      const auto missed = std::ranges::count_if(inside, [&](const dvec3& p) {
        return std::ranges::none_of(
            middles, [&](const dvec3& m) { return Dot(m - p, m - p) <= radius * radius; });
      });
      EXPECT_GT(inside.size(), 500U);
      EXPECT_LT(1'000 * missed, std::ssize(inside)) << "of " << inside.size();
    }
  }
}

TEST(DrawnTest, OnALeftToothItIsTheMirrorImage) {
  const auto right = *BuildBuiltinScene("molar", kVoxel_nm);
  const auto left = *BuildBuiltinScene("molar-left", kVoxel_nm);
  const auto of_right = DrawnExercises(right.scene, {}), of_left = DrawnExercises(left.scene, {});
  ASSERT_EQ(of_right.size(), of_left.size());
  ASSERT_FALSE(of_right.empty());
  for (size_t i = 0; i < of_right.size(); ++i) {
    const auto a = *TargetShape(right.scene, of_right[i].target);
    const auto b = *TargetShape(left.scene, of_left[i].target);
    for (double x = -4e-3; x < 4e-3; x += 0.37e-3)
      for (double y = -3e-3; y < 3e-3; y += 0.41e-3)
        for (double z = -5e-3; z < 3e-3; z += 0.9e-3)
          EXPECT_NEAR(PreparationDistance_m(a, {x, y, z}), PreparationDistance_m(b, {-x, y, z}),
                      1e-12);
  }
}

}  // namespace
}  // namespace enamel::scene
