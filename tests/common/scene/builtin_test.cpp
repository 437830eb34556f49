#include "common/scene/builtin/builtin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "common/scene/builtin/teeth.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/preparation.h"
#include "common/scene/volume_blob.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr int32_t kVoxel_nm = 200'000;

dvec3 Metres(const PointUm& p) { return dvec3(p[0], p[1], p[2]) * 1e-6; }

double PulpOf_mm3(const Volume& volume) {
  return cutting::SolidVolume_m3(volume)[static_cast<size_t>(Tissue::kPulp)] * 1e9;
}

Volume PreparedOf(const BuiltScene& built, const Exercise& e) {
  const auto shape = TargetShape(built.scene, e.target);
  EXPECT_TRUE(shape.ok()) << e.name;
  return shape.ok() ? Prepared(built.volume, *shape) : Volume(built.volume.spec());
}

// By the exact task.
double PulpTaken_mm3(const BuiltScene& built, const Exercise& e) {
  return PulpOf_mm3(built.volume) - PulpOf_mm3(PreparedOf(built, e));
}

template <typename F>
void ForEachVoxel(const cutting::GridSpec& spec, const F& f) {
  const ivec3 n = spec.voxels();
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x) f(spec.origin_m() + dvec3(x, y, z) * spec.voxel_m());
}

class BuiltinSceneTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    auto built = BuildBuiltinScene(GetParam(), kVoxel_nm);
    ASSERT_TRUE(built.ok()) << built.status().message();
    built_ = std::move(*built);
  }
  BuiltScene built_;
};
INSTANTIATE_TEST_SUITE_P(Scenes, BuiltinSceneTest, testing::ValuesIn(BuiltinSceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(BuiltinSceneTest, VolumeHashNamesTheVolumeAndTheDocumentReadsBackToTheSameBytes) {
  EXPECT_EQ(built_.scene.volume, HashSha256(EncodeVolume(built_.volume)));
  std::string text = ToJson(built_.scene);
  auto back = SceneFromJson(text);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(ToJson(*back), text);
}

TEST_P(BuiltinSceneTest, NamesExactlyTheTissuesItsVolumeHolds) {
  auto volumes = cutting::SolidVolume_m3(built_.volume);
  std::set<Tissue> named;
  for (const TissueSpec& t : built_.scene.tissues) named.insert(t.tissue);
  for (int t = 1; t < cutting::kTissueCount; ++t) {
    EXPECT_EQ(volumes[static_cast<size_t>(t)] > 0, named.count(static_cast<Tissue>(t)) == 1)
        << cutting::TissueName(static_cast<Tissue>(t));
  }
  EXPECT_TRUE(CheckVolume(built_.scene, built_.volume).ok());
}

TEST_P(BuiltinSceneTest, ExercisesReadBackAndCompileForAPapersDevice) {
  Sha256 hash = HashSha256(AsBytes(ToJson(built_.scene)));
  auto exercises = BuiltinExercises(built_.scene, hash);
  EXPECT_FALSE(exercises.empty());
  for (const Exercise& e : exercises) {
    auto back = ExerciseFromJson(ToJson(e));
    ASSERT_TRUE(back.ok()) << back.status().message();
    auto params = CompilePlan(built_.scene, *back, BuiltinProfiles()[1]);
    EXPECT_TRUE(params.ok()) << e.name << ": " << params.status().message();
  }
}

// Every rubric prices whatever of its tooth can be harmed, whatever the exercise. Where the task itself opens the pulp, and
// only there, no exposure is critical.
TEST_P(BuiltinSceneTest, EveryRubricPricesWhatTheToothCanLose) {
  const Scene& scene = built_.scene;
  const auto has = [&](Tissue tissue) {
    return std::ranges::any_of(scene.tissues,
                               [&](const TissueSpec& t) { return t.tissue == tissue; });
  };
  for (const Exercise& e : BuiltinExercises(scene, Sha256{})) {
    SCOPED_TRACE(e.name);
    const auto prices = [&](const char* kind) {
      return std::ranges::count(e.rubric.prices, kind, &RubricPrice::of) == 1;
    };
    const auto fails = [&](const char* error) {
      return std::ranges::count(e.rubric.critical, error, &RubricCritical::error) > 0;
    };
    EXPECT_TRUE(prices("elsewhere"));
    EXPECT_TRUE(fails("all_cut") && fails("nothing_cut"));
    if (has(Tissue::kNeighbour)) {
      EXPECT_TRUE(prices("neighbour"));
    }
    if (has(Tissue::kPulp)) {
      EXPECT_TRUE(prices("pulp"));
      EXPECT_NE(fails("pulp_exposed"), PulpTaken_mm3(built_, e) > 0.1);
    }
    // Caries that is not in an exercise's cavity is another's.
    if (e.name.starts_with("caries") || e.name.starts_with("class-2")) {
      EXPECT_TRUE(prices("caries"));
    }
  }
}

// A tooth whose canals are to be found shows them from above: nothing of the roof and no horn is left beside the opening.
TEST_P(BuiltinSceneTest, AnOpenedChamberHasNoRoofLeft) {
  const Volume whole = built_.volume;
  const double all_mm3 = PulpOf_mm3(whole);
  for (const Exercise& e : BuiltinExercises(built_.scene, Sha256{})) {
    if (!(PulpTaken_mm3(built_, e) > 0.1)) continue;
    SCOPED_TRACE(e.name);
    const Volume open = PreparedOf(built_, e);
    const double h = open.spec().voxel_m();
    const double floor_m =
        Metres(built_.scene.landmarks.at(e.target.landmark)).z - e.target.depth_um * 1e-6;
    double left_mm3 = 0;
    ForEachVoxel(open.spec(), [&](const dvec3& p) {
      if (p.z < floor_m + h || open.DistanceAt_m(p) > 0) return;
      if (open.TissueAtPoint(p) == Tissue::kPulp) left_mm3 += h * h * h * 1e9;
    });
    EXPECT_LT(left_mm3, 0.005 * all_mm3);
  }
}

TEST_P(BuiltinSceneTest, LandmarksOfCavitiesLieOnTheSurface) {
  for (const auto& [name, at] : built_.scene.landmarks) {
    if (name == "crown_top" || name == "mesial_box") continue;
    EXPECT_NEAR(built_.volume.DistanceAt_m(Metres(at)), 0, 40e-6) << name;
  }
}

TEST(BuiltinMolarTest, ClassOneCavityLeavesAtLeastHalfAMillimetreOfDentinOverThePulp) {
  const ToothShape& molar = LowerFirstMolar();
  Scene scene;
  scene.name = "molar";
  Exercise e = ClassOneExercise(scene, {});
  dvec3 c = FossaBottom_m(molar);
  double floor = c.z - (e.target.depth_um + e.target.leeway_bottom_um) * 1e-6 - 0.5e-3;
  double hx = (e.target.half_size_um[0] + e.target.leeway_side_um) * 1e-6 + 0.5e-3;
  double hy = (e.target.half_size_um[1] + e.target.leeway_side_um) * 1e-6 + 0.5e-3;
  for (double x = -hx; x <= hx; x += 0.1e-3)
    for (double y = -hy; y <= hy; y += 0.1e-3)
      for (double z = floor; z < c.z; z += 0.2e-3) {
        ASSERT_NE(ToothField(molar, {c.x + x, c.y + y, z}).tissue, Tissue::kPulp)
            << x << " " << y << " " << z;
      }
}

TEST(BuiltinClassTwoTest, TargetBoxIsOfTheToothAloneAndEndsShortOfTheNeighbour) {
  auto built = BuildBuiltinScene("molar-class-2", 100'000);
  ASSERT_TRUE(built.ok());
  CavityTarget target;
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    if (e.target.landmark == "mesial_box") target = e.target;
  }
  dvec3 c = Metres(built->scene.landmarks.at("mesial_box"));
  int own = 0, neighbour = 0;
  double h = 0.1e-3;
  for (double x = -target.half_size_um[0] * 1e-6; x <= target.half_size_um[0] * 1e-6; x += h)
    for (double y = -target.half_size_um[1] * 1e-6; y <= target.half_size_um[1] * 1e-6; y += h)
      for (double z = -target.depth_um * 1e-6; z < 2e-3; z += h) {
        dvec3 p = c + dvec3(x, y, z);
        if (built->volume.DistanceAt_m(p) > 0) continue;
        // Within half a voxel of the face the nearest label may be the neighbour's.
        if (built->volume.TissueAtPoint(p) == Tissue::kNeighbour) ++neighbour;
        ++own;
      }
  EXPECT_GT(own, 3'000);
  EXPECT_EQ(neighbour, 0);
}

TEST(BlockTest, VolumeIsThatOfTheBox) {
  auto block = BuildBuiltinScene("block", kVoxel_nm);
  ASSERT_TRUE(block.ok());
  auto v = cutting::SolidVolume_m3(block->volume);
  EXPECT_NEAR(v[static_cast<size_t>(Tissue::kGypsum)] * 1e9, 4000, 4);
}

TEST(BlockTest, PreparedShapesTakeAwayTheirClosedFormVolumes) {
  auto block = BuildBuiltinScene("block", 100'000);
  ASSERT_TRUE(block.ok());
  const std::map<std::string, double> expected_mm3 = {
      {"circle", 3.14159265358979 * 2.5 * 2.5 * 1.5},
      {"cross", (2 * 6 * 1.5 - 1.5 * 1.5) * 1.5},
      {"line", 7 * 1.5 * 1.5},
      {"step", 3 * 3 * 1.0 + 3 * 3 * 2.0}};
  double before = cutting::SolidVolume_m3(block->volume)[static_cast<size_t>(Tissue::kGypsum)];
  ASSERT_EQ(block->scene.preparations.size(), expected_mm3.size());
  for (const Preparation& p : block->scene.preparations) {
    auto after = cutting::SolidVolume_m3(Prepared(block->volume, p));
    double gone = (before - after[static_cast<size_t>(Tissue::kGypsum)]) * 1e9;
    EXPECT_NEAR(gone / expected_mm3.at(p.name), 1, 0.01) << p.name;
  }
}

TEST(BlockTest, FloorsOfPreparedShapesLieAtTheirDepth) {
  auto block = BuildBuiltinScene("block", 100'000);
  ASSERT_TRUE(block.ok());
  for (const Preparation& p : block->scene.preparations) {
    cutting::Volume prepared = Prepared(block->volume, p);
    for (const PreparationPart& part : p.parts) {
      dvec3 floor = Metres(part.top_um) - dvec3(0, 0, part.depth_um * 1e-6);
      // Another part may go deeper here; the union's floor is then the other's.
      double d = PreparationDistance_m(p, floor);
      EXPECT_NEAR(prepared.DistanceAt_m(floor), std::max(-d, 0.0), 30e-6) << p.name;
    }
  }
}

TEST(BuiltinTest, UnknownNameListsTheKnownOnes) {
  auto none = BuildBuiltinScene("wisdom", 100'000);
  EXPECT_EQ(none.status().code(), Code::kNotFound);
  EXPECT_NE(none.status().message().find("molar, premolar, incisor"), std::string::npos);
}

TEST(BuiltinTest, VoxelThatNeedsMoreMemoryThanAllowedIsRefusedWithOneThatFits) {
  constexpr size_t kAllowed = 40'000'000;
  auto refused = BuildBuiltinScene("molar", 50'000, kAllowed);
  ASSERT_EQ(refused.status().code(), Code::kTooLarge);
  EXPECT_EQ(refused.status().field(), "voxel_nm");
  const std::string& text = refused.status().message();
  size_t at = text.find("at least ");
  ASSERT_NE(at, std::string::npos) << text;
  int32_t fits = std::stoi(text.substr(at + 9));
  EXPECT_TRUE(BuildBuiltinScene("molar", fits, kAllowed).ok());
  EXPECT_EQ(BuildBuiltinScene("molar", fits - 1'000, kAllowed).status().code(), Code::kTooLarge);
}

TEST(BuiltinTest, MemoryThatHoldsNoVoxelAtAllIsSaidSo) {
  auto refused = BuildBuiltinScene("molar", 100'000, 10'000);
  ASSERT_EQ(refused.status().code(), Code::kTooLarge);
  EXPECT_NE(refused.status().message().find("no voxel"), std::string::npos);
}

// Practice has gentle touch cues; graded work has none unless somebody writes an exercise that
// does.
TEST(BuiltinExercisesTest, OperativeAndEndodonticWorkHasARubberDam) {
  std::map<std::string, bool> found;
  for (const char* name : {"block", "molar", "molar-class-2", "molar-buccal", "incisor-labial"}) {
    auto built = BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok()) << built.status().message();
    for (const Exercise& e : BuiltinExercises(built->scene, {})) {
      const bool practice = built->scene.tooth == 0;
      found[practice ? "practice" : e.name.substr(0, e.name.find('-'))] =
          e.isolation == Isolation::kRubberDam;
    }
  }
  EXPECT_EQ(found, (std::map<std::string, bool>{{"access", true},
                                                {"class", true},
                                                {"crown", false},
                                                {"fissures", true},
                                                {"mod", true},
                                                {"practice", false},
                                                {"trapezoid", true},
                                                {"veneer", false}}));
}

TEST(BuiltinExercisesTest, PracticeHasTouchCuesAndGradedWorkHasNone) {
  bool practice = false, graded = false;
  for (const char* name : {"block", "molar-class-2"}) {
    auto built = BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok()) << built.status().message();
    for (const Exercise& e : BuiltinExercises(built->scene, {})) {
      EXPECT_EQ(e.touch_cues == TouchCueSpec{}, e.graded) << e.name;
      (e.graded ? graded : practice) = true;
    }
  }
  EXPECT_TRUE(practice);
  EXPECT_TRUE(graded);
}

}  // namespace
}  // namespace enamel::scene
