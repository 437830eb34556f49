#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "station/lab/laws/hand_trial.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

DeviceModel Device(int i) { return *ModelOf(QualifyProfiles()[static_cast<size_t>(i)]); }

// A synthetic recording like a person's: slow strokes with two harmonics.
std::string RecordingText(int rows) {
  std::string text = "t_s,px_m,py_m,pz_m,vx,vy,vz\n";
  for (int i = 0; i < rows; ++i) {
    double t = i * 1e-3;
    char line[160];
    std::snprintf(line, sizeof line, "%.3f,%.9f,%.9f,%.9f,0,0,0\n", t, 0.05 * std::sin(2 * t),
                  0.03 * std::sin(5 * t), 0.001 * t);
    text += line;
  }
  return text;
}

fs::path Folder(const char* name, const std::string& text) {
  fs::path folder = fs::path(testing::TempDir()) / name;
  fs::create_directories(folder);
  std::ofstream(folder / "rec.csv") << text;
  return folder;
}

TEST(MotionsTest, AMinimumJerkStrokePeaksAtItsKnownSpeedAndReturns) {
  HandMotion m = StrokesMotion(1e-3, 1, 2, kOblique);
  WayReader way(m.way_m);
  // 15/8 of the mean, Flash and Hogan 1985.
  EXPECT_NEAR(glm::length(way.SpeedAt(0.5)), 1.875e-3, 1e-6);
  EXPECT_NEAR(glm::length(way.SpeedAt(1.0)), 0, 1e-6);
  EXPECT_NEAR(glm::length(way.PositionAt(2.0)), 0, 1e-9);
  EXPECT_NEAR(MeanSpeed(m), 1e-3, 1e-6);
}

TEST(MotionsTest, ScalingKeepsTheTimeAndSetsTheSpeed) {
  HandMotion m = WanderingMotion(0.2e-3, 5, 3);
  EXPECT_NEAR(MeanSpeed(m), 0.2e-3, 1e-9);
  EXPECT_EQ(WanderingMotion(0.2e-3, 5, 3).way_m, m.way_m);
  EXPECT_NE(WanderingMotion(0.2e-3, 5, 4).way_m, m.way_m);
  HandMotion twice = ScaledToSpeed(m, 0.4e-3);
  EXPECT_EQ(twice.way_m.size(), m.way_m.size());
  EXPECT_NEAR(MeanSpeed(twice), 0.4e-3, 1e-9);
}

TEST(MotionsTest, RecordingsAreReadAndWhatIsNoRecordingIsRefusedByLine) {
  auto good = RecordedMotions(Folder("recordings", RecordingText(500)).string());
  ASSERT_TRUE(good.ok()) << good.status().message();
  ASSERT_EQ(good->size(), 1u);
  EXPECT_EQ((*good)[0].name, "human-rec");
  EXPECT_NEAR((*good)[0].way_m[250].x, 0.05 * std::sin(0.5), 1e-4);
  auto none = RecordedMotions((fs::path(testing::TempDir()) / "no such folder").string());
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->empty());
  for (const char* bad : {"a,b\n1,2\n", "t_s,px_m,py_m,pz_m\n0,1,2\n",
                          "t_s,px_m,py_m,pz_m\n0,1,x,3\n", "t_s,px_m,py_m,pz_m\n0,1,2,nan\n",
                          "t_s,px_m,py_m,pz_m\n0.5,1,2,3\n", "t_s,px_m,py_m,pz_m\n0,1,2,3\n"}) {
    auto refused = RecordedMotions(Folder("bad", bad).string());
    ASSERT_FALSE(refused.ok()) << bad;
    EXPECT_NE(refused.status().message().find("rec.csv:"), std::string::npos);
  }
}

class HandOnDevice : public testing::TestWithParam<int> {
 protected:
  DeviceModel device_ = Device(GetParam());
};

// With a tick of delay, on turned joints and in soft hands, no more energy comes out than went in.
TEST_P(HandOnDevice, NoHandDrawsEnergyWhateverTheLatticeAndTheDelay) {
  for (int delay : {0, 1}) {
    for (bool turned : {false, true}) {
      for (HandKind hand : {HandKind::kVelocity, HandKind::kForce, HandKind::kImpedance}) {
        HandTrial t;
        t.hand = hand;
        t.delay_ticks = delay;
        DeviceModel m = device_;
        m.delay_ticks = delay;
        m.kc_n_per_m = std::min(m.kc_n_per_m, m.PassiveKc(m.rate_hz));
        if (turned) {
          dvec3 x = glm::normalize(dvec3(0.8, 0.5, -0.3)),
                y = glm::normalize(glm::cross(dvec3(0, 0.2, 1), x));
          t.lattice.joints = glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
        }
        HandFigures f = RunHand(m, t, WanderingMotion(0.4e-3, 4, 5));
        EXPECT_GE(f.energy_min_j, -1e-12) << delay << turned << static_cast<int>(hand);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, HandOnDevice, testing::Values(0, 1, 2), [](const auto& i) {
  return QualifyProfiles()[static_cast<size_t>(i.param)].name;
});

}  // namespace
}  // namespace enamel::station::lab
