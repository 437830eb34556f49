#include "common/scene/pruning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "common/core/core.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/parts.h"
#include "common/scene/plan.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr int32_t kVoxel_nm = 200'000;

// Down from free air to the target's floor, a spiral around it, and up again: the bur stays within
// the reach, touches whatever is there and turns on the way.
std::vector<core::TickInput> Wander(const core::CoreParams& params, const Exercise& exercise) {
  std::vector<core::TickInput> out;
  double unit_m = params.resolution_nm[0] * 1e-9;
  double depth = 8e-3 + exercise.target.depth_um * 1e-6;
  double hx = exercise.target.half_size_um[0] * 1e-6, hy = exercise.target.half_size_um[1] * 1e-6;
  constexpr int kDown = 1500, kAround = 4000;
  for (uint32_t i = 0; i < params.soft_start_ticks + 10; ++i) out.push_back({});
  auto go = [&](double x, double y, double z, double turn) {
    core::TickInput in;
    in.counts = {static_cast<int32_t>(std::lround(x / unit_m)),
                 static_cast<int32_t>(std::lround(y / unit_m)),
                 static_cast<int32_t>(std::lround(z / unit_m))};
    in.orientation = ToQuantised(Quat{turn, 0.5 * turn, 0, 1}.Normalised());
    in.flags = core::kBurOn;
    out.push_back(in);
  };
  for (int i = 0; i < kDown; ++i) go(0, 0, -depth * i / kDown, 0);
  for (int i = 0; i < kAround; ++i) {
    double s = static_cast<double>(i) / kAround, a = 25 * s;
    go(s * hx * std::cos(a), s * hy * std::sin(a), -depth, 0.1 * std::sin(3 * a));
  }
  for (int i = 0; i < kDown; ++i) go(hx, 0, -depth * (kDown - i) / kDown, 0);
  return out;
}

struct Outcome {
  uint64_t hash = 0;
  cutting::RemovedUnits removed{};
  bool operator==(const Outcome&) const = default;
};

Outcome Replayed(const core::CoreParams& params, const Volume& volume,
                 const std::vector<core::TickInput>& inputs) {
  core::Core core(params, volume);
  for (const core::TickInput& in : inputs) core.Step(in);
  return {core.state_hash(), core.removed()};
}

class PruningTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, PruningTest, testing::ValuesIn(BuiltinSceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(PruningTest, NeverChangesTheHashOfAnyExercise) {
  auto built = BuildBuiltinScene(GetParam(), kVoxel_nm);
  ASSERT_TRUE(built.ok());
  Volume full = Unpruned(built->volume), pruned = Pruned(built->volume);
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    auto params = CompilePlan(built->scene, e, BuiltinProfiles()[1]);
    ASSERT_TRUE(params.ok()) << params.status().message();
    auto inputs = Wander(*params, e);
    Outcome as_built = Replayed(*params, built->volume, inputs);
    int64_t all = 0;
    for (int64_t r : as_built.removed) all += r;
    EXPECT_GT(all, 0) << e.name << ": nothing was cut, nothing was compared";
    EXPECT_EQ(Replayed(*params, full, inputs), as_built) << e.name;
    EXPECT_EQ(Replayed(*params, pruned, inputs), as_built) << e.name;
    Volume reached = Pruned(built->volume, ReachOf(built->scene, e));
    EXPECT_EQ(Replayed(*params, reached, inputs), as_built) << e.name;
  }
}

TEST_P(PruningTest, LeavesNoSurfaceInsideTheReachOut) {
  auto built = BuildBuiltinScene(GetParam(), kVoxel_nm);
  ASSERT_TRUE(built.ok());
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    Reach reach = ReachOf(built->scene, e);
    Volume reached = Pruned(built->volume, reach);
    double h = kVoxel_nm * 1e-9;
    for (double x = reach.lo_nm[0] * 1e-9; x < reach.hi_nm[0] * 1e-9; x += 1.3 * h)
      for (double y = reach.lo_nm[1] * 1e-9; y < reach.hi_nm[1] * 1e-9; y += 1.3 * h)
        for (double z = reach.lo_nm[2] * 1e-9; z < reach.hi_nm[2] * 1e-9; z += 1.3 * h) {
          ASSERT_EQ(reached.DistanceAt_m({x, y, z}), built->volume.DistanceAt_m({x, y, z}));
        }
  }
}

TEST(PruningMemoryTest, UnprunedCostsMoreThanBuiltAndTheReachLess) {
  auto built = BuildBuiltinScene("molar-class-2", kVoxel_nm);
  ASSERT_TRUE(built.ok());
  Exercise e = ClassOneExercise(built->scene, {});
  size_t plain = built->volume.MemoryBytes();
  EXPECT_GT(Unpruned(built->volume).MemoryBytes(), plain + plain / 4);
  EXPECT_LT(Pruned(built->volume, ReachOf(built->scene, e)).MemoryBytes(), plain / 2);
  EXPECT_LT(Without(built->volume, Tissue::kNeighbour).MemoryBytes(), plain);
}

TEST(PruningTightTest, UnprunedThenPrunedIsTheBuiltVolumeAgain) {
  for (const char* name : {"molar", "block"}) {
    auto built = BuildBuiltinScene(name, kVoxel_nm);
    ASSERT_TRUE(built.ok());
    EXPECT_TRUE(Pruned(Unpruned(built->volume)) == Pruned(built->volume)) << name;
    EXPECT_LE(Pruned(Unpruned(built->volume)).MemoryBytes(), built->volume.MemoryBytes()) << name;
  }
}

const Part& Find(const std::vector<Part>& parts, PartId id) {
  for (const Part& p : parts) {
    if (p.id == id) return p;
  }
  ADD_FAILURE();
  return parts[0];
}

TEST(PartsTest, SingleTissueNeedsNoLabelsAndNoNeighbourNoNeighbourVolume) {
  Scene scene;
  Exercise e;
  scene.tissues = DefaultTissues({Tissue::kGypsum});
  auto parts = ListParts(scene, e, {});
  EXPECT_FALSE(Find(parts, PartId::kLabels).kept);
  EXPECT_FALSE(Find(parts, PartId::kNeighbour).kept);
  scene.tissues = DefaultTissues({Tissue::kEnamel, Tissue::kNeighbour});
  parts = ListParts(scene, e, {});
  EXPECT_TRUE(Find(parts, PartId::kLabels).kept);
  EXPECT_TRUE(Find(parts, PartId::kNeighbour).kept);
}

TEST(PartsTest, TouchCuesAreThereWhereTheExerciseAsksForThem) {
  Scene scene;
  Exercise e;
  for (bool graded : {true, false}) {
    e.graded = graded;
    e.touch_cues = {};
    EXPECT_FALSE(Find(ListParts(scene, e, {}), PartId::kTouchCues).kept);
    e.touch_cues = {250, 100, 200, 1'000};
    const auto parts = ListParts(scene, e, {});
    const Part& part = Find(parts, PartId::kTouchCues);
    EXPECT_TRUE(part.kept);
    EXPECT_NE(part.why.find("250 mN on contact"), std::string::npos) << part.why;
  }
}

TEST(PartsTest, WindowNeedsTheSurfaceAndAReplayNeitherSurfaceNorBus) {
  Scene scene;
  Exercise e;
  scene.tissues = DefaultTissues({Tissue::kGypsum});
  EXPECT_FALSE(Find(ListParts(scene, e, {}), PartId::kSurface).kept);
  EXPECT_TRUE(Find(ListParts(scene, e, {true, false}), PartId::kSurface).kept);
  auto replay = ListParts(scene, e, {true, true});
  EXPECT_FALSE(Find(replay, PartId::kSurface).kept);
  EXPECT_FALSE(Find(replay, PartId::kBusWrite).kept);
  EXPECT_TRUE(Find(replay, PartId::kForceBounds).kept);
}

TEST(PartsTest, TheMouthIsDrawnAroundAToothInAWindowAndTheMirrorOnlyWhileItIsHeld) {
  Scene scene;
  Exercise e;
  EXPECT_FALSE(Find(ListParts(scene, e, {true, false}), PartId::kMouth).kept) << "no tooth";
  scene.tooth = 46;
  EXPECT_TRUE(Find(ListParts(scene, e, {true, false}), PartId::kMouth).kept);
  EXPECT_FALSE(Find(ListParts(scene, e, {false, false}), PartId::kMouth).kept);
  EXPECT_FALSE(Find(ListParts(scene, e, {true, true}), PartId::kMouth).kept);
  EXPECT_FALSE(Find(ListParts(scene, e, {true, false}), PartId::kMirror).kept);
}

TEST(PartsTest, TheDamIsThereWhereTheExerciseAsksForItAndTheMouthIsDrawn) {
  Scene scene;
  Exercise e;
  scene.tooth = 46;
  EXPECT_FALSE(Find(ListParts(scene, e, {true, false}), PartId::kRubberDam).kept);
  EXPECT_TRUE(Find(ListParts(scene, e, {true, false}), PartId::kAntagonist).kept);
  e.isolation = Isolation::kRubberDam;
  EXPECT_TRUE(Find(ListParts(scene, e, {true, false}), PartId::kRubberDam).kept);
  EXPECT_FALSE(Find(ListParts(scene, e, {false, false}), PartId::kRubberDam).kept);
  EXPECT_FALSE(Find(ListParts(scene, e, {false, false}), PartId::kAntagonist).kept);
}

TEST(PartsTest, TorqueIsCarriedExactlyWhereTheDeviceDrivesRotation) {
  Scene scene;
  Exercise e;
  scene.tissues = DefaultTissues({Tissue::kGypsum});
  EXPECT_FALSE(Find(ListParts(scene, e, {}), PartId::kTorque).kept);
  EXPECT_TRUE(Find(ListParts(scene, e, {.torque = true}), PartId::kTorque).kept);
  EXPECT_TRUE(Find(ListParts(scene, e, {.replay = true, .torque = true}), PartId::kTorque).kept);
}

}  // namespace
}  // namespace enamel::scene
