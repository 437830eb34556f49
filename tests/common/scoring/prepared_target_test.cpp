#include "common/scene/prepared_target.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "common/scoring/score.h"
#include "common/scoring/zones.h"
#include "tests/common/scoring/synthetic_cavity.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

// The box of BlockExercise, once as parts say it and once as the block with it gone.
struct Task {
  Volume block;
  scene::Exercise shape = BlockExercise(), prepared = BlockExercise();
  Volume wanted;

  explicit Task(int32_t voxel_nm = 100'000) : block(MakeBlock(voxel_nm)) {
    shape.target.leeway_bottom_um = shape.target.leeway_side_um = 200;
    wanted = scene::Prepared(block, *scene::TargetShape(BlockScene(), shape.target));
    prepared.target = *scene::TargetFromPrepared(BlockScene(), block, wanted,
                                                 HashSha256(AsBytes(std::string_view("x"))), 200);
    prepared.target.container_um = shape.target.container_um;
  }
};

// Volume of a zone inside the block, or of what was removed of it.
double Inside_mm3(const Volume& block, const Volume& cut, const ZoneBoxes& zones, Zone zone,
                  bool removed) {
  const BoxVolume volume = MeasureZone(block, cut, zones, zone);
  return 1e9 * (removed ? volume.removed_m3 : volume.solid_m3);
}

ZoneBoxes GrownZones(const Volume& block, const scene::CavityTarget& target) {
  ZoneBoxes zones = *BoxesOf(BlockScene(), target);
  GrowZones(block, zones);
  return zones;
}

TEST(PreparedTargetZonesTest, AreThoseOfTheShapeItWasMadeOf) {
  const Task task(50'000);
  Cavity deep;
  deep.mesial_mm += 0.45;
  deep.depth_mm += 0.1;
  const Cut cut(task.block, deep);
  // A box of 3 x 2.4 x 2 mm; the leeway's edges are round here and square there, which is 1 - pi/4
  // of 0.2 mm squared along the upright edges and the floor's.
  const ZoneBoxes of_shape = GrownZones(task.block, task.shape.target),
                  of_tooth = GrownZones(task.block, task.prepared.target);
  const double edges = 4 * 2 + 2 * (3 + 2.4);
  for (const Zone zone : {Zone::kTarget, Zone::kLeeway, Zone::kContainer}) {
    const double grown = zone == Zone::kTarget ? 0 : zone == Zone::kLeeway ? 0.2 : 0.7;
    const double round_mm3 = (1 - std::acos(-1.0) / 4) * grown * grown * (edges + 12 * grown);
    for (const bool removed : {false, true}) {
      const double by_shape = Inside_mm3(task.block, cut.volume, of_shape, zone, removed),
                   by_tooth = Inside_mm3(task.block, cut.volume, of_tooth, zone, removed);
      EXPECT_NEAR(by_tooth, by_shape, 0.15 + round_mm3) << static_cast<int>(zone) << removed;
      EXPECT_LE(by_tooth, by_shape + 0.15);
    }
  }
}

TEST(PreparedTargetZonesTest, OfTheWantedToothAllOfTheTargetIsGoneAndNothingBeyond) {
  const Task task;
  const ZoneBoxes zones = GrownZones(task.block, task.prepared.target);
  const BoxVolume target = MeasureZone(task.block, task.wanted, zones, Zone::kTarget);
  const BoxVolume leeway = MeasureZone(task.block, task.wanted, zones, Zone::kLeeway);
  const BoxVolume container = MeasureZone(task.block, task.wanted, zones, Zone::kContainer);
  EXPECT_EQ(target.removed_m3, target.solid_m3);
  EXPECT_NEAR(1e9 * target.solid_m3, 3 * 2.4 * 2, 0.05);
  EXPECT_NEAR(1e9 * (leeway.removed_m3 - target.removed_m3), 0, 1e-3);
  EXPECT_NEAR(1e9 * (container.removed_m3 - target.removed_m3), 0, 1e-3);
  EXPECT_GT(container.solid_m3, leeway.solid_m3);
}

// A target's own tooth costs nothing, for work that was neither slow nor hard; and it has no path, as nobody cut it.
TEST(PreparedTargetScoreTest, ThePerfectCutScoresAHundredAndDeviatesByNothing) {
  const Task task;
  const surface::Mesh mesh = surface::ExtractSurface(task.wanted);
  const ProcessRecorder process = StraightRecording(200, 1, 1);
  const AttemptData attempt{&task.block, &task.wanted, &mesh, &process};
  const AttemptData wanted{&task.block, &task.wanted, &mesh, nullptr};
  scene::Exercise exercise = scene::PreparedExercise(BlockScene(), {}, task.prepared.target);
  auto metrics = ComputeMetrics(BlockScene(), exercise, attempt, wanted);
  ASSERT_TRUE(metrics.ok()) << metrics.status().message();
  for (const char* name : {"deviation_rms_mm", "deviation_p95_mm", "wall_mesial_mm", "floor_mm",
                           "outside_removed_mm3", "missed_mm3"}) {
    EXPECT_EQ(ValueOf(*metrics, name), 0) << name;
  }
  EXPECT_NEAR(ValueOf(*metrics, "zone_target_removed_percent"), 100, 1e-9);
  for (const MissingMetric& missing : metrics->missing) {
    // Nobody's path, and a box is no crown.
    if (missing.name.starts_with("dtw_") || missing.name.starts_with("finish_")) {
      EXPECT_EQ(missing.why, NoValue::kNotInTask) << missing.name;
    }
  }
  const AcceptableCut r(task.block, task.wanted, {});
  auto cut = JudgeCut(r, task.wanted, exercise.rubric);
  ASSERT_TRUE(cut.ok()) << cut.status().message();
  EXPECT_TRUE(cut->found.mistakes.empty());
  auto score = ApplyRubric(exercise.rubric, *metrics, cut->measures);
  ASSERT_TRUE(score.ok()) << score.status().message();
  EXPECT_EQ(score->score, 100);
}

TEST(PreparedTargetScoreTest, AWallThatIsTooDeepIsFoundAsWithARecordedReference) {
  const Task task;
  Cavity deep;
  deep.mesial_mm += 0.3;
  const Cut cut(task.block, deep), reference(task.block, {});
  const surface::Mesh mesh = surface::ExtractSurface(task.wanted);
  auto metrics = ComputeMetrics(BlockScene(), task.prepared, cut.Data(task.block),
                                {&task.block, &task.wanted, &mesh, nullptr});
  ASSERT_TRUE(metrics.ok()) << metrics.status().message();
  EXPECT_NEAR(ValueOf(*metrics, "wall_mesial_mm"), 0.3, 0.025);
  EXPECT_NEAR(ValueOf(*metrics, "wall_distal_mm"), 0, 0.025);
}

TEST(PreparedTargetScoreTest, AToothThatWasNotLoadedIsAnErrorAndNoBox) {
  Task task;
  task.prepared.target.prepared_tooth = nullptr;
  const Cut cut(task.block, {});
  auto metrics =
      ComputeMetrics(BlockScene(), task.prepared, cut.Data(task.block), cut.Data(task.block));
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().code(), Code::kNotFound);
}

}  // namespace
}  // namespace enamel::scoring
