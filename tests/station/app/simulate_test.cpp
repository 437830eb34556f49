#include "station/app/simulate.h"

#include <gtest/gtest.h>

#include "common/base/sha256.h"
#include "common/scene/json/json.h"

namespace enamel::station {
namespace {

// The built-in molar and its exercise at the demo's voxel size; built once.
const scene::BuiltScene& Molar() {
  static const scene::BuiltScene* built = [] {
    auto made = scene::BuildBuiltinScene("molar", 50'000);
    ENAMEL_CHECK(made.ok());
    return new scene::BuiltScene(std::move(*made));
  }();
  return *built;
}

SimulationReport Cut(const std::string& operator_name,
                     const std::string& device = "phantom_desktop") {
  scene::Exercise exercise =
      scene::ClassOneExercise(Molar().scene, HashSha256(AsBytes(scene::ToJson(Molar().scene))));
  for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
    if (profile.name != device) continue;
    auto report = Simulate(Molar(), exercise, profile, operator_name);
    ENAMEL_CHECK(report.ok());
    return std::move(*report);
  }
  ENAMEL_CHECK(false);
  return {};
}

double Median(const SimulationReport& report, const std::string& plane) {
  for (const PlaneError& p : report.planes) {
    if (p.name == plane) return p.median_um;
  }
  return 1e9;
}

// He considers a floor done within 7 um (cavity_plan.cpp). The Phantom's spring hides c/Kc = 10 um in each
// direction from his hand: the cell that its friction pays for.
TEST(SimulateTest, DentistCutsEveryPlaneToTwentyMicrometres) {
  SimulationReport report = Cut("dentist");
  EXPECT_TRUE(report.finished);
  for (const PlaneError& p : report.planes) EXPECT_LE(std::abs(p.median_um), 20) << p.name;
  EXPECT_GE(report.ticks, 30'000u);
  EXPECT_EQ(report.bounded_ticks, 0u);
  EXPECT_GT(report.force_p95_n, 0.5);
  EXPECT_LT(report.force_max_n, 2.5);
  EXPECT_EQ(report.removed_mm3[static_cast<size_t>(cutting::Tissue::kPulp)], 0);
  // The box and the tooth above it: at least 4.0 x 2.4 x 2.0 mm less four round corners.
  double corners = (4 - 3.14159265) * 0.5 * 0.5 * 2;
  EXPECT_GT(report.removed_mm3[1] + report.removed_mm3[2], 4.0 * 2.4 * 2.0 - corners - 0.6);
}

TEST(SimulateTest, DentistIsWithinHalfAVoxelOnTheOtherDevices) {
  for (const char* device : {"omega3", "bhhd3"}) {
    SimulationReport report = Cut("dentist", device);
    EXPECT_TRUE(report.finished) << device;
    for (const PlaneError& p : report.planes)
      EXPECT_LE(std::abs(p.median_um), 25) << device << " " << p.name;
  }
}

TEST(SimulateTest, StudentsMesialWallIsThreeTenthsTooFarAndNothingElse) {
  SimulationReport report = Cut("student-deep-mesial");
  EXPECT_TRUE(report.finished);
  EXPECT_NEAR(Median(report, "mesial"), 300, 50.0 / 4);
  for (const char* other : {"distal", "buccal", "lingual", "floor"}) {
    EXPECT_LE(std::abs(Median(report, other)), 20) << other;
  }
}

TEST(SimulateTest, SameSeedGivesTheSameStateHash) {
  auto block = scene::BuildBuiltinScene("block", 100'000);
  ASSERT_TRUE(block.ok());
  scene::Exercise exercise =
      scene::ClassOneExercise(block->scene, HashSha256(AsBytes(scene::ToJson(block->scene))));
  auto run = [&](uint64_t seed) {
    auto report = Simulate(*block, exercise, scene::BuiltinProfiles()[1], "dentist", seed, 20'000);
    EXPECT_TRUE(report.ok());
    return report->state_hash;
  };
  EXPECT_EQ(run(5), run(5));
  EXPECT_NE(run(5), run(6));
}

}  // namespace
}  // namespace enamel::station
