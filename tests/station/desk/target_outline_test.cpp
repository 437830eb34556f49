#include "station/desk/target_outline.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "common/scene/builtin/builtin.h"

namespace enamel::station::desk {
namespace {

// The exercise whose name begins like this, with its tooth.
struct Task {
  scene::BuiltScene built;
  scene::CavityTarget target;
};
Task TaskOf(const char* scene, const std::string& exercise) {
  Task out{*scene::BuildBuiltinScene(scene, 100'000), {}};
  for (const scene::Exercise& e : scene::BuiltinExercises(out.built.scene, Sha256{})) {
    if (e.name.starts_with(exercise)) {
      out.target = e.target;
      return out;
    }
  }
  ADD_FAILURE() << exercise;
  return out;
}

double Length_mm(const std::vector<surface::LineSegment>& lines) {
  double sum = 0;
  for (const auto& line : lines) sum += 1e3 * glm::length(line.to_m - line.from_m);
  return sum;
}

TEST(TargetOutlineTest, OfABoxItLiesInTheBoxesWallsOnTheTooth) {
  const Task task = TaskOf("molar", "class-1");
  const auto lines = OutlineOf(task.built.scene, task.target, task.built.volume);
  const scene::PointUm at = task.built.scene.landmarks.at(task.target.landmark);
  const double hx = task.target.half_size_um[0] * 1e-3, hy = task.target.half_size_um[1] * 1e-3;
  for (const surface::LineSegment& line : lines) {
    const double x = std::abs(1e3 * line.from_m.x - at[0] * 1e-3),
                 y = std::abs(1e3 * line.from_m.y - at[1] * 1e-3);
    EXPECT_NEAR(std::max(x - hx, y - hy), 0, 0.05);  // half a voxel, at corners
    EXPECT_NEAR(task.built.volume.DistanceAt_m(dvec3(line.from_m)), 0, 0.02e-3);
  }
  // Up and down over the fissures, so longer than the box's outline seen from above.
  EXPECT_GT(Length_mm(lines), 4 * (hx + hy));
  EXPECT_LT(Length_mm(lines), 8 * (hx + hy));
}

TEST(TargetOutlineTest, OfEveryBuiltinExerciseThereIsOne) {
  for (const char* name : {"molar", "block"}) {
    const auto built = scene::BuildBuiltinScene(name, 100'000);
    ASSERT_TRUE(built.ok());
    for (const scene::Exercise& e : scene::BuiltinExercises(built->scene, Sha256{})) {
      EXPECT_GT(Length_mm(OutlineOf(built->scene, e.target, built->volume)), 2) << e.name;
    }
  }
}

TEST(TargetOutlineTest, WithoutATargetInTheSceneThereIsNone) {
  Task task = TaskOf("molar", "class-1");
  task.target.landmark = "nowhere";
  EXPECT_TRUE(OutlineOf(task.built.scene, task.target, task.built.volume).empty());
}

TEST(TargetOutlineTest, ItIsTakenOnceWhenItIsThere) {
  const Task task = TaskOf("molar", "class-1");
  scene::Exercise exercise;
  exercise.target = task.target;
  for (const bool mouth : {false, true}) {
    Surroundings around(task.built.scene, exercise, task.built.volume, mouth);
    while (!around.done()) std::this_thread::yield();
    const auto found = around.Take();
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->outline.empty());
    EXPECT_EQ(found->mouth.empty(), !mouth);
    EXPECT_TRUE(around.done());
    EXPECT_FALSE(around.Take());
  }
}

}  // namespace
}  // namespace enamel::station::desk
