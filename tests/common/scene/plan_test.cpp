#include "common/scene/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/scene/builder.h"
#include "common/scene/builtin.h"
#include "common/scene/json.h"

namespace enamel::scene {
namespace {

Scene SomeScene() {
  Scene s;
  s.name = "some";
  s.title = "Some";
  s.voxel_nm = 50'000;
  s.tissues = DefaultTissues({cutting::Tissue::kEnamel, cutting::Tissue::kDentin});
  s.landmarks["occlusal_centre"] = {100, -200, 2'000};
  s.provenance = "test";
  return s;
}

struct PlanTest : testing::Test {
  Scene scene = SomeScene();
  Exercise exercise = ClassOneExercise(scene, HashSha256(AsBytes(ToJson(scene))));
  DeviceProfile profile = BuiltinProfiles()[1];
};

TEST_F(PlanTest, PaperDevicesCarryTheExerciseWithThePapersStiffness) {
  const int32_t kc[3] = {10'000, 2'500, 4'000};
  for (size_t i = 0; i < 3; ++i) {
    auto params = CompilePlan(scene, exercise, BuiltinProfiles()[i]);
    ASSERT_TRUE(params.ok()) << params.status().message();
    EXPECT_EQ(params->kc_mn_per_mm, kc[i]);
  }
}

TEST_F(PlanTest, CountZeroIsEightMillimetresAboveTheLandmark) {
  auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok());
  EXPECT_EQ(params->device_origin_nm, (std::array<int64_t, 3>{100'000, -200'000, 10'000'000}));
  EXPECT_EQ(params->soft_start_ticks, 500u);
  EXPECT_EQ(params->damping_mn_s_per_mm[1], 8'700);
  EXPECT_EQ(params->damping_mn_s_per_mm[0], 0);
}

TEST_F(PlanTest, StiffnessAtThePassiveLimitIsAllowedAndAboveItRefusedWithTheLimit) {
  profile.coupling_mn_per_mm.value = 3'500;  // 2 b f = K, as b = K T/2
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
  profile.coupling_mn_per_mm.value = 3'501;
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("at most 3500 mN/mm"), std::string::npos) << refused.message();
}

TEST_F(PlanTest, BusDelayLowersThePassiveLimit) {
  profile.bus_delay_ticks.value = 1;  // 3500 / 4
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_NE(refused.message().find("at most 875 mN/mm"), std::string::npos) << refused.message();
  profile.coupling_mn_per_mm.value = 875;
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
}

TEST_F(PlanTest, FrictionBelowHalfACellOfCouplingIsRefusedWithWhatIsNeeded) {
  profile.friction_mn.value = 12;  // 2500 * 0.010 / 2 = 12.5
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "friction_mn");
  EXPECT_NE(refused.message().find("c to at least 13 mN"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("Kc to at most 2400 mN/mm"), std::string::npos)
      << refused.message();
}

// None unless the exercise says so, graded or not.
TEST_F(PlanTest, TouchCuesAreThoseOfTheExercise) {
  for (bool graded : {true, false}) {
    exercise.graded = graded;
    exercise.touch_cues = {};
    auto params = CompilePlan(scene, exercise, profile);
    ASSERT_TRUE(params.ok());
    EXPECT_EQ(params->contact_cue_mn, 0);
    EXPECT_EQ(params->chatter_cue_mn, 0);
    EXPECT_EQ(params->cue_energy_nj, 0);
    EXPECT_EQ(params->cue_power_nw, 0);
    exercise.touch_cues = {2'000, 100, 1'000, 10'000};
    params = CompilePlan(scene, exercise, profile);
    ASSERT_TRUE(params.ok()) << params.status().message();
    EXPECT_EQ(params->contact_cue_mn, 2'000);
    EXPECT_EQ(params->chatter_cue_mn, 100);
    EXPECT_EQ(params->cue_energy_nj, 1'000'000);
    EXPECT_EQ(params->cue_power_nw, 10'000'000);
  }
}

TEST_F(PlanTest, TouchCuesInALoopTooSlowForThemAreRefused) {
  exercise.touch_cues = {250, 100, 200, 1'000};
  profile.coupling_mn_per_mm.value = 500;  // within the passive limit of a slow loop
  exercise.rate_hz = 300;
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
  exercise.rate_hz = 299;
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "touch_cues");
  EXPECT_NE(refused.message().find("at least 300 Hz"), std::string::npos) << refused.message();
  exercise.touch_cues = {};
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
}

TEST_F(PlanTest, FasterExerciseThanTheDeviceIsRefused) {
  exercise.rate_hz = 4'000;
  EXPECT_EQ(CompilePlan(scene, exercise, profile).status().field(), "rate_hz");
}

TEST_F(PlanTest, MissingLandmarkIsRefused) {
  exercise.target.landmark = "mesial_pit";
  EXPECT_EQ(CompilePlan(scene, exercise, profile).status().field(), "landmark");
}

TEST_F(PlanTest, BurTheSceneDoesNotOfferIsRefusedWithThoseItHas) {
  scene.burs = {{"round-16", cutting::BurShape::kSphere, 800, 0}};
  exercise.scene = {};
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_EQ(refused.field(), "bur");
  EXPECT_NE(refused.message().find("round-16 (sphere of radius 800 um"), std::string::npos)
      << refused.message();
  scene.burs.push_back(exercise.bur());
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
}

// A 2 mm cube of enamel in a grid of 3 mm.
cutting::Volume EnamelCube() {
  auto field = [](const dvec3& p) {
    double d = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1e-3;
    return FieldSample{d, cutting::Tissue::kEnamel, 1};
  };
  return BuildVolume(GridAround(dvec3(-1e-3), dvec3(1e-3), 50'000), Field(field));
}

TEST_F(PlanTest, TissueOfTheVolumeThatTheSceneDoesNotNameIsRefused) {
  scene.tissues = DefaultTissues({cutting::Tissue::kDentin});
  Status refused = CheckVolume(scene, EnamelCube());
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("enamel, which it does not name"), std::string::npos)
      << refused.message();
}

TEST_F(PlanTest, TissueTheSceneNamesThatTheVolumeHasNotIsRefused) {
  Status refused = CheckVolume(scene, EnamelCube());
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("dentin, of which its volume holds none"), std::string::npos)
      << refused.message();
  scene.tissues = DefaultTissues({cutting::Tissue::kEnamel});
  EXPECT_TRUE(CheckVolume(scene, EnamelCube()).ok());
}

TEST_F(PlanTest, VolumeOfAnotherVoxelSizeIsRefused) {
  scene.tissues = DefaultTissues({cutting::Tissue::kEnamel});
  scene.voxel_nm = 25'000;
  EXPECT_EQ(CheckVolume(scene, EnamelCube()).field(), "voxel_nm");
}

TEST_F(PlanTest, AnotherSceneThanTheExercisesIsAConflict) {
  scene.title = "Another";
  EXPECT_EQ(CompilePlan(scene, exercise, profile).status().code(), Code::kConflict);
}

}  // namespace
}  // namespace enamel::scene
