#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "station/lab/suites/hand_cases.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

DeviceModel Device(int i) { return *ModelOf(ShippedProfiles()[static_cast<size_t>(i)]); }

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
  void Run(HandCases* cases) {
    for (HandCase& one : *cases) one.run(one.row);
  }
  DeviceModel device_ = Device(GetParam());
};

// Grips of 1, 2 and 5 N/mm. Elsewhere the law is as good as plain Maxwell, to a point and a half or 2 mN.
TEST_P(HandOnDevice, AGripFeelsTheDamperBetterThanThroughAPlainSpring) {
  HandCases cases;
  HandMotion wandering = WanderingMotion(0.2e-3, 8, 1),
             strokes = StrokesMotion(0.43e-3, 2, 4, kOblique);
  wandering.name = "wandering";
  strokes.name = "strokes-2s";
  AddFeltCases(device_, {wandering, strokes}, {6500}, &cases);
  Run(&cases);
  double law = 0, plain = 0;
  for (const HandCase& one : cases) {
    const HandRow& r = one.row;
    const std::string what = r.motion + " " + std::to_string(r.hand_n_per_mm);
    EXPECT_GE(r.energy_min_j, -1e-12) << what;
    EXPECT_TRUE(r.proved) << what;
    if (!(r.hand_n_per_mm >= 0.3) || std::isnan(r.felt_error)) continue;
    // A light grip hardly moves a device that rubs: points of a force of 0.03 N are fractions of a mN.
    EXPECT_LE(r.felt_error, r.maxwell_error + std::max(0.015, 2e-3 / r.ideal_rms_n)) << what;
    if (r.hand_n_per_mm < 1 || r.hand_n_per_mm > 5 || r.motion == "wandering") continue;
    law += r.felt_error;
    plain += r.maxwell_error;
  }
  EXPECT_LT(law, 0.9 * plain);
}

TEST_P(HandOnDevice, TheBudgetSaysWhatASteadyCutAndStrokesAreMadeOf) {
  QualifyOptions options;
  options.quick = true;
  Findings findings;
  findings.models = {device_};
  SuiteContext context{options, findings, [](const char*, size_t, size_t) {}};
  AddFeltInHand(context, {});
  ASSERT_EQ(findings.budgets.size(), 2u);
  for (const BudgetRow& row : findings.budgets) {
    double sum = 0, friction = 0;
    for (const fidelity::FeltPart& p : row.budget.parts) {
      sum += p.share;
      if (p.cause == std::string("friction")) friction = p.rms_n;
    }
    EXPECT_NEAR(sum, 1, 1e-9) << row.hand;
    // A prescribed cut meets c on each of three axes; a hand that gives yields to a part of it.
    EXPECT_LE(friction, std::sqrt(3.0) * device_.friction_n * 1.001) << row.hand;
    EXPECT_GE(row.budget.p95_n, row.budget.rms_n * 0.9) << row.hand;
  }
  EXPECT_NEAR(findings.budgets[0].budget.parts[3].rms_n, std::sqrt(3.0) * device_.friction_n, 1e-6);
  EXPECT_NEAR(findings.budgets[0].budget.tool_rms_n, 6500 * 0.43e-3, 1e-6);
  ASSERT_EQ(findings.seconds_felt.size(), 20u);
  for (const SecondsRow& row : findings.seconds_felt) {
    EXPECT_GE(row.seconds, 15) << row.b_n_s_per_mm;
    EXPECT_LE(row.within, row.seconds);
  }
  // Where friction is the error, harder tissue and faster strokes are felt better: it is a smaller share of them.
  if (device_.name == "omega3") {
    EXPECT_GT(findings.seconds_felt.back().share(), findings.seconds_felt.front().share());
  }
}

TEST_P(HandOnDevice, RecordedStrokesAreFeltAsTheReadmeSays) {
  auto recorded = RecordedMotions(std::string(ENAMEL_SOURCE_DIR) + "/../shared/data/motion");
  ASSERT_TRUE(recorded.ok()) << recorded.status().message();
  if (recorded->empty()) GTEST_SKIP() << "skipped: no shared data";
  // Percent, Omega, Phantom, BHhd, in hands of 1, 2 and 5 N/mm.
  constexpr double kFelt[3][3] = {{8, 10, 17}, {16, 24, 39}, {11, 18, 31}};
  HandCases cases;
  for (HandMotion& motion : *recorded) motion = ScaledToSpeed(motion, 0.2e-3);
  AddFeltCases(device_, *recorded, {6500}, &cases);
  Run(&cases);
  for (int grip = 0; grip < 3; ++grip) {
    double sum = 0;
    for (const HandCase& one : cases) {
      if (one.row.hand_n_per_mm == (grip == 0 ? 1.0 : grip == 1 ? 2.0 : 5.0))
        sum += one.row.felt_error / static_cast<double>(recorded->size());
    }
    EXPECT_LE(100 * sum, kFelt[GetParam()][grip]) << grip;
  }
}

// With a tick of delay, on turned joints, rounded again and with noise: no more comes out than went in,
// wherever the clause carries Kc.
TEST_P(HandOnDevice, NoHandDrawsEnergyWhateverTheLatticeAndTheDelay) {
  HandCases cases;
  HandMotion motion = WanderingMotion(0.4e-3, 4, 5);
  AddReadingCases(device_, {motion}, &cases);
  Run(&cases);
  int proved = 0;
  for (const HandCase& one : cases) {
    if (!one.row.proved) continue;
    ++proved;
    EXPECT_GE(one.row.energy_min_j, -1e-12) << one.row.lattice << " " << one.row.delay_ticks;
  }
  EXPECT_GE(proved, 8);
}

TEST_P(HandOnDevice, AHandThatLiftsIsNotHeldAndNotThrownBack) {
  HandCases cases;
  AddLiftCases(device_, &cases);
  Run(&cases);
  int thrown = 0;
  for (const HandCase& one : cases) {
    EXPECT_LE(one.row.pull_n, 0.15) << one.row.motion;
    thrown += one.row.cycles;
  }
  EXPECT_EQ(cases.size(), 72u);
  EXPECT_LE(thrown, 3);
}

// Every sixth of the 288 hands; all of them: enamel-lab qualify --suite hand.
TEST_P(HandOnDevice, AHandThatPushesSwingsNoMoreThanWithAPlainSpring) {
  HandCases cases;
  AddPushCases(device_, &cases);
  ASSERT_EQ(cases.size(), 288u);
  const double allowed = std::max(0.06, 0.6 * device_.kc_n_per_m * device_.resolution_m);
  for (size_t i = static_cast<size_t>(GetParam()); i < cases.size(); i += 6) {
    HandRow& r = cases[i].row;
    cases[i].run(r);
    EXPECT_LE(r.swing_n, r.maxwell_swing_n + allowed) << i;
  }
}

// In tissue that is cut by load: every 25th of 288, so that each load and hardness has its turn, with lead and plain. What is
// left is the encoder's grain: 0.28 N peak to peak at most in all of them, as with R = B v. A law that is told of a wall where
// the bur is slow swings by 2 N on the Phantom.
TEST_P(HandOnDevice, AHandThatLeansOnTissueCutByLoadDoesNotSwing) {
  HandCases cases;
  AddLoadPushCases(device_, &cases);
  ASSERT_EQ(cases.size(), 288u);
  for (size_t i = static_cast<size_t>(GetParam()); i < cases.size(); i += 25) {
    HandRow& r = cases[i].row;
    cases[i].run(r);
    EXPECT_LE(std::max(r.swing_n, r.maxwell_swing_n), 0.3) << i;
    EXPECT_GE(r.energy_min_j, -1e-12) << i;
  }
}

TEST_P(HandOnDevice, AFirstStrokeAfterAirIsNoStrongerThanTheTissue) {
  HandCases cases;
  AddApproachCases(device_, &cases);
  Run(&cases);
  for (const HandCase& one : cases) {
    const HandRow& r = one.row;
    if (!std::isnan(r.excess_n)) EXPECT_LE(r.excess_n, 0.15) << r.motion;
    if (std::isnan(r.way_m)) continue;
    EXPECT_LE(r.way_m, r.maxwell_way_m + device_.resolution_m + 1e-12) << r.motion;
    EXPECT_LE(r.behind_m, 1e-9) << r.motion;
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, HandOnDevice, testing::Values(0, 1, 2), [](const auto& i) {
  return ShippedProfiles()[static_cast<size_t>(i.param)].name;
});

}  // namespace
}  // namespace enamel::station::lab
