#include "common/scene/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/scene/builder.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/own_friction.h"

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

TEST_F(PlanTest, FrictionIsKnownOfAMeasuredUnitGuessedOfAKindAndNoneOfAMouse) {
  EXPECT_EQ(CompilePlan(scene, exercise, profile)->friction_mn, (std::array{25, 25, 25}));
  EXPECT_FALSE(CompilePlan(scene, exercise, profile)->friction_measured);
  profile.friction_measured = true;
  EXPECT_FALSE(CompilePlan(scene, exercise, profile)->friction_measured) << "of another unit";
  profile.friction_of_unit = true;
  EXPECT_TRUE(CompilePlan(scene, exercise, profile)->friction_measured);
  const DeviceProfile mouse = *FindProfile("pointer");
  EXPECT_EQ(CompilePlan(scene, exercise, mouse)->friction_mn, (std::array{0, 0, 0}));
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
  profile.friction_mn.value = 100;
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

// 2 b f/(d + 1)^2 with the board's f and d: 3500 * 8/4. What the loop and its bus take does not count.
TEST_F(PlanTest, ASpringOnTheBoardIsBoundedByTheBoardsTimeAndNotByTheLoops) {
  profile.friction_mn.value = 200;
  profile.max_stiffness_mn_per_mm.value = 20'000;
  profile.coupling_mn_per_mm.value = 7'000;
  EXPECT_FALSE(CompilePlan(scene, exercise, profile).ok());
  profile.board_spring = BoardSpringSpec{8'000, 1, "test"};
  profile.bus_delay_ticks.value = 2;
  const auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok()) << params.status().message();
  EXPECT_TRUE(params->spring_on_board);
  EXPECT_EQ(params->kc_mn_per_mm, 7'000);
  EXPECT_EQ(params->bus_delay_ticks, 2u);
  profile.coupling_mn_per_mm.value = 7'001;
  const Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_NE(refused.message().find("at most 7000 mN/mm"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("at 8000 Hz and 1 ticks of delay of the board's spring"),
            std::string::npos)
      << refused.message();
}

TEST_F(PlanTest, ASpringOnTheBoardNeedsALawThatHasARestPoint) {
  profile.board_spring = BoardSpringSpec{8'000, 1, "test"};
  exercise.law = haptics::LawKind::kPaperLimited;
  const Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "law");
  exercise.law = haptics::LawKind::kMaxwell;
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
}

TEST_F(PlanTest, FrictionBelowHalfACellOfCouplingIsRefusedWithWhatIsNeeded) {
  profile.cell.reset();
  profile.friction_mn.value = 12;  // 2500 * 0.010 / 2 = 12.5
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "friction_mn");
  EXPECT_NE(refused.message().find("c to at least 13 mN"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("Kc to at most 2400 mN/mm"), std::string::npos)
      << refused.message();
}

// sqrt(3)/2 of a cell, and as much of a count: 2500 * (8.66 + 0.43 um) = 22.7 mN; with a count of noise three
// times the cell.
TEST_F(PlanTest, CellsOfJointsAndNoiseCostMoreFriction) {
  auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok()) << params.status().message();
  EXPECT_EQ(params->resolution_nm[0], 500);
  EXPECT_EQ(params->cell_half_nm, (std::array<int32_t, 3>{250, 250, 250}));
  EXPECT_EQ(params->cell_ball_nm, 8'661);
  profile.friction_mn.value = 22;
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "friction_mn");
  EXPECT_NE(refused.message().find("Kc to at most 2418 mN/mm"), std::string::npos)
      << refused.message();
  profile.friction_mn.value = 25;
  profile.cell->noise_counts = 1;
  EXPECT_NE(CompilePlan(scene, exercise, profile).status().message().find("at most 946 mN/mm"),
            std::string::npos);
}

// m (2 pi f1/4)^2 = 45 g * 100 Hz^2 * 2.4674 = 1110 N/m.
TEST_F(PlanTest, AFirstResonanceNearTheCouplingsIsRefusedWithTheLargestKc) {
  profile.structural_mode_hz = {160, "test"};
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
  profile.structural_mode_hz.value = 100;
  Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_NE(refused.message().find("first resonance"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("at most 1110 mN/mm"), std::string::npos) << refused.message();
}

// No cues unless the exercise asks for them, graded or not.
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

// b = 1.75 N s/m of its own; 0.25 more by its current loop: 2 b f = 4000.
TEST_F(PlanTest, ElectricalDampingCountsAsTheDevicesOwn) {
  profile.friction_mn.value = 100;
  profile.max_stiffness_mn_per_mm.value = 10'000;
  profile.electrical_damping_mn_s_per_m = {250, "measured"};
  profile.coupling_mn_per_mm.value = 4'000;
  EXPECT_TRUE(CompilePlan(scene, exercise, profile).ok());
  profile.coupling_mn_per_mm.value = 4'001;
  EXPECT_NE(CompilePlan(scene, exercise, profile).status().message().find("at most 4000 mN/mm"),
            std::string::npos);
}

TEST_F(PlanTest, ADeviceOfThreeAxesTurnsTheBurAsItDidAndSendsNoTorque) {
  auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok());
  EXPECT_EQ(params->peak_torque_un_m, 0);
  EXPECT_EQ(params->rotation_cell_urad, 0);
  const double half_m = 0.5e-6 * exercise.bur_length_um;
  EXPECT_NEAR(params->rotational_kc_un_m_per_rad, 2500 * half_m * half_m * 1e6, 1);
}

// sigma7: K = 0.8 N m/rad, b_rot = 0.5 mN m s/rad (2 b f = 1 N m/rad), c_rot = 1 mN m, 0.3 mrad.
TEST_F(PlanTest, TorqueIsCompiledFromTheProfileAndRefusedWhereItWouldPump) {
  profile = BuiltinProfiles().back();
  ASSERT_EQ(profile.name, "sigma7");
  auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok()) << params.status().message();
  EXPECT_EQ(params->rotational_kc_un_m_per_rad, 800'000);
  EXPECT_EQ(params->peak_torque_un_m, 200'000);
  EXPECT_EQ(params->rotation_cell_urad, 300);

  auto refused = [&](auto change) {
    DeviceProfile changed = profile;
    change(*changed.torque);
    return CompilePlan(scene, exercise, changed).status();
  };
  EXPECT_TRUE(refused([](TorqueSpec& t) { t.coupling_un_m_per_rad.value = 1'000'000; }).ok());
  Status stiff = refused([](TorqueSpec& t) { t.coupling_un_m_per_rad.value = 1'000'001; });
  EXPECT_EQ(stiff.field(), "coupling_un_m_per_rad");
  EXPECT_NE(stiff.message().find("set at most 1000000"), std::string::npos) << stiff.message();
  EXPECT_TRUE(refused([](TorqueSpec& t) { t.friction_un_m.value = 240; }).ok());
  Status smooth = refused([](TorqueSpec& t) { t.friction_un_m.value = 239; });
  EXPECT_EQ(smooth.field(), "friction_un_m");
  EXPECT_NE(smooth.message().find("c_rot to at least 240"), std::string::npos) << smooth.message();
  EXPECT_NE(smooth.message().find("K to at most 796666"), std::string::npos) << smooth.message();
  EXPECT_TRUE(refused([](TorqueSpec& t) { t.peak_un_m.value = 480; }).ok());
  EXPECT_EQ(refused([](TorqueSpec& t) { t.peak_un_m.value = 479; }).field(), "peak_un_m");
  // A tick of delay quarters it.
  profile.bus_delay_ticks.value = 1;
  profile.coupling_mn_per_mm.value = 900;
  EXPECT_EQ(CompilePlan(scene, exercise, profile).status().field(), "coupling_un_m_per_rad");
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

TEST_F(PlanTest, OtherBursComeWithTheStiffnessOfTheirOwnHeight) {
  exercise.other_burs = {{{}, cutting::BurShape::kPear, 600, 2'000, 350}};
  auto params = CompilePlan(scene, exercise, profile);
  ASSERT_TRUE(params.ok()) << params.status().message();
  // 2.5 N/mm at 1 mm.
  EXPECT_EQ(params->other_burs, (std::vector<core::OtherBur>{{cutting::BurShape::kPear, 600'000,
                                                              2'000'000, 350'000, 0, 0, 2'500}}));
  EXPECT_EQ(params->rotational_kc_un_m_per_rad, 10'000) << "4 mm long";
  // With a spring that is felt, that of the device.
  params = CompilePlan(scene, exercise, BuiltinProfiles().back());
  ASSERT_TRUE(params.ok()) << params.status().message();
  EXPECT_GT(params->peak_torque_un_m, 0);
  EXPECT_EQ(params->other_burs[0].rotational_kc_un_m_per_rad, params->rotational_kc_un_m_per_rad);
}

TEST_F(PlanTest, EachBurIsOneThatTheSceneOffersAndItsVoxelCarries) {
  exercise.other_burs = {{{}, cutting::BurShape::kSphere, 300, 0}};
  scene.burs = {exercise.bur()};
  exercise.scene = {};
  const Status refused = CompilePlan(scene, exercise, profile).status();
  EXPECT_EQ(refused.field(), "bur");
  EXPECT_NE(refused.message().find("sphere of radius 300 um"), std::string::npos)
      << refused.message();
  exercise.other_burs.clear();
  EXPECT_EQ(WhyTooCoarse(exercise, 100'000), std::nullopt);
  exercise.other_burs = {{{}, cutting::BurShape::kSphere, 300, 0}};
  const auto coarse = WhyTooCoarse(exercise, 100'000);
  ASSERT_TRUE(coarse);
  EXPECT_NE(coarse->find("sphere r 0.3 mm"), std::string::npos) << *coarse;
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
