#include "common/fidelity/feel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/fidelity/tracks.h"
#include "common/scene/builtin/builtin.h"

namespace enamel::fidelity {
namespace {

constexpr double kCut = 0.43e-3;

scene::DeviceProfile Profile(std::string_view name) {
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (p.name == name) return p;
  }
  ADD_FAILURE() << "no built-in profile " << name;
  return {};
}

// So stiff and fine that only the thresholds and the law's own care are left.
Device Stiff() { return {"stiff", 1e-9, 2e6, 1e-3, 0, 100, 100}; }
Device Soft() { return {"soft", 1e-6, 20, 1e-3, 0, 100, 100}; }
const Tissue kEnamel{"enamel", 8700};

TEST(TracksTest, AMinimumJerkStrokeGoesItsWayAndItsRateIsTheDerivative) {
  EXPECT_EQ(MinimumJerk(-1), 0);
  EXPECT_EQ(MinimumJerk(0.5), 0.5);
  EXPECT_EQ(MinimumJerk(2), 1);
  EXPECT_EQ(MinimumJerkRate(0.5), 1.875);
  for (double u : {0.1, 0.3, 0.77}) {
    double h = 1e-6;
    EXPECT_NEAR(MinimumJerkRate(u), (MinimumJerk(u + h) - MinimumJerk(u - h)) / (2 * h), 1e-8);
  }
}

TEST(TracksTest, TheOracleFallsAtOnceAndRisesByNoMoreThanItsSlope) {
  EXPECT_EQ(OracleStep({5, 0, 0}, {0, 1, 0}, 0.1, 10), dvec3(0, 1, 0));
  EXPECT_NEAR(glm::length(OracleStep({1, 0, 0}, {0, 3, 4}, 0.5, 10)), 1.5, 1e-12);
  EXPECT_NEAR(glm::length(OracleStep({1, 0, 0}, {0, 3, 4}, 50, 2)), 2, 1e-12)
      << "not above the peak";
}

TEST(TracksTest, ACellHoldsItsMiddleAndWhatIsWithinHalfACell) {
  for (double x : {-3.7e-5, -1e-9, 0.0, 2.6e-5}) {
    double middle = CellMiddle({x, x, x}, 1e-5).x;
    EXPECT_LE(std::fabs(middle - x), 0.5e-5 * (1 + 1e-9));
    EXPECT_NEAR(middle / 1e-5 - std::floor(middle / 1e-5), 0.5, 1e-6);
  }
}

TEST(FeelTest, AStiffAndFineDeviceIsFeltAsItIs) {
  for (Motion motion : kMotions) {
    for (double b : {300.0, 8700.0}) {
      Cell cell = Simulate(Stiff(), {"any", b}, 1e-3, motion);
      EXPECT_EQ(cell.verdict, Verdict::kFelt)
          << MotionName(motion) << " b " << b << ": error " << cell.law.error << " lag "
          << cell.law.lag_s << " rise " << cell.law.rise_s;
    }
  }
}

TEST(FeelTest, ASoftDeviceCannotAndNeitherCouldAnotherLaw) {
  for (Motion motion : kMotions) {
    Cell cell = Simulate(Soft(), kEnamel, kCut, motion);
    EXPECT_EQ(cell.verdict, Verdict::kDeviceCannot) << MotionName(motion);
    EXPECT_FALSE(Holds(motion, cell.oracle));
    EXPECT_GT(cell.law.error, kViscosityShare);
    EXPECT_LT(cell.law.gain, 1 - kViscosityShare) << "it feels softer, not harder";
  }
}

TEST(FeelTest, ForceAboveTheMotorsIsBeyondThem) {
  constexpr double kFast = 1e-3;
  Device weak = Stiff();
  weak.continuous_force_n = 8.6;  // B V is 8.7 N, the RMS of strokes 1.195 times that
  Cell steady = Simulate(weak, kEnamel, kFast, Motion::kSteady);
  EXPECT_EQ(steady.verdict, Verdict::kBeyondForce);
  EXPECT_NEAR(steady.rms_n, 8700 * kFast, 1e-9);
  weak.continuous_force_n = 8.8;
  EXPECT_EQ(Simulate(weak, kEnamel, kFast, Motion::kSteady).verdict, Verdict::kFelt);
  // RMS of 30 u^2 (1-u)^2 is sqrt(10/7).
  Cell strokes = Simulate(weak, kEnamel, kFast, Motion::kStrokes);
  EXPECT_NEAR(strokes.rms_n, 8700 * kFast * std::sqrt(10.0 / 7), 1e-4);
  EXPECT_EQ(strokes.verdict, Verdict::kBeyondForce);
  weak.continuous_force_n = 100;
  weak.peak_force_n = 1.87 * 8700 * kFast;
  EXPECT_EQ(Simulate(weak, kEnamel, kFast, Motion::kStrokes).verdict, Verdict::kBeyondForce)
      << "its fastest moment, 1.875 times the mean, is above the peak";
}

TEST(FeelTest, TheOraclesRiseIsItsClosedForm) {
  // From 0 at slope Kc v to 93 % of B v: 0.93 B/Kc, whatever the speed.
  for (double speed : kSpeeds_m_per_s) {
    Device d = *AsItStands(Profile("omega3"));
    Cell cell = Simulate(d, {"dentin", 5200}, speed, Motion::kSteady);
    EXPECT_NEAR(cell.oracle.rise_s, 0.93 * 5200 / d.kc_n_per_m, d.tick_s);
    EXPECT_NEAR(cell.oracle.error, 0, 1e-12);
    EXPECT_NEAR(cell.oracle.gain, 1, 1e-12);
  }
}

// Strokes on encoders from nanometres to what the paper's devices have: a finer one never feels
// worse than the coarsest. Where a tick holds many counts the law once lost the stroke altogether.
TEST(FeelTest, AFinerEncoderFollowsStrokesNoWorse) {
  for (double b : {300.0, 3000.0, 6500.0, 11300.0}) {
    const Tissue tissue{"tissue", b};
    const auto error = [&](double cell_m) {
      return Simulate({"fine", cell_m, 10'000, 1e-3, 0, 12, 12}, tissue, kCut, Motion::kStrokes)
          .law.error;
    };
    const double coarse = error(9e-6);
    for (double cell_m : {3e-6, 1e-6, 0.3e-6, 0.1e-6, 0.01e-6, 1e-9}) {
      EXPECT_LE(error(cell_m), coarse) << "B " << b << ", cells of " << cell_m << " m";
    }
  }
}

TEST(FeelTest, DelayIsFelt) {
  // Force that comes n ticks late lags by n ticks, and RMS of f(t) - f(t - L) is what the lag
  // costs.
  Device late = Stiff();
  late.delay_ticks = 20;
  Cell cell = Simulate(late, {"caries", 1000}, kCut, Motion::kStrokes);
  EXPECT_NEAR(cell.oracle.lag_s, 0.020, 1.01e-3);
  EXPECT_FALSE(Holds(Motion::kStrokes, cell.oracle));
  Cell prompt = Simulate(Stiff(), {"caries", 1000}, kCut, Motion::kStrokes);
  EXPECT_LE(prompt.oracle.lag_s, 1.01e-3);
  EXPECT_TRUE(Holds(Motion::kStrokes, prompt.oracle));
}

TEST(FeelTest, CoulombsPartAndThresholdArePartOfWhatIsRight) {
  Tissue tissue{"enamel", 1000, 0.5, 0.8};
  EXPECT_EQ(RightForce_n(tissue, 0), 0);
  EXPECT_DOUBLE_EQ(RightForce_n(tissue, 0.1e-3), 0.8);
  EXPECT_DOUBLE_EQ(RightForce_n(tissue, 1e-3), 1.5);
  Cell cell = Simulate(Stiff(), tissue, 1e-3, Motion::kSteady);
  EXPECT_NEAR(cell.rms_n, 1.5, 1e-12);
  EXPECT_NEAR(cell.law.gain, 1, kForceShare);
}

// The verdict again, from the words.
Verdict Said(const Device& d, const Cell& c) {
  auto fine = [&](const Figures& f) {
    double delay = c.motion == Motion::kSteady ? f.rise_s : f.lag_s;
    return f.error <= 0.07 && 0 <= delay && delay <= 0.015;
  };
  if (c.rms_n > d.continuous_force_n || c.largest_n > d.peak_force_n) return Verdict::kBeyondForce;
  if (fine(c.law)) return Verdict::kFelt;
  if (c.law.error <= 0.07) return Verdict::kLate;
  if (c.law.error <= 0.19) return Verdict::kNearly;
  return fine(c.oracle) ? Verdict::kLawShort : Verdict::kDeviceCannot;
}

TEST(FeelTest, EveryVerdictOfEveryDeviceFollowsFromItsFigures) {
  const std::vector<Tissue> tissues = {kEnamel, {"caries", 1000}, {"pulp", 300}};
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (!HasMotors(p)) continue;
    Device device = Attached(p)->device;
    std::vector<Cell> map = MapOf(device, tissues);
    ASSERT_EQ(map.size(), tissues.size() * 4 * 2);
    for (const Cell& cell : map) {
      EXPECT_EQ(cell.verdict, Said(device, cell)) << p.name << " " << tissues[cell.tissue].name;
      EXPECT_TRUE(std::isfinite(cell.law.error) && std::isfinite(cell.law.gain));
      EXPECT_LE(cell.oracle.gain, 1 + 1e-9) << "it never gives more than what is right";
    }
    EXPECT_EQ(map.front().tissue, 0u);
    EXPECT_EQ(map.back().tissue, tissues.size() - 1);
  }
}

TEST(FeelTest, VerdictsAreFoundAtTheirEdges) {
  Device d = Stiff();
  Cell c;
  c.motion = Motion::kStrokes;
  c.rms_n = c.largest_n = 1;
  c.law = {kForceShare, 1, kDelay_s, 0};
  c.oracle = {0, 1, 0, 0};
  EXPECT_EQ(VerdictOf(d, c), Verdict::kFelt);
  c.law.lag_s = 0.016;
  EXPECT_EQ(VerdictOf(d, c), Verdict::kLate);
  c.law.error = 0.071;
  EXPECT_EQ(VerdictOf(d, c), Verdict::kNearly);
  c.law.error = 0.191;
  EXPECT_EQ(VerdictOf(d, c), Verdict::kLawShort);
  c.oracle.lag_s = 0.016;
  EXPECT_EQ(VerdictOf(d, c), Verdict::kDeviceCannot);
  c.largest_n = 100.1;
  EXPECT_EQ(VerdictOf(d, c), Verdict::kBeyondForce);
  c.motion = Motion::kSteady;
  c.largest_n = 1;
  c.law = {0.01, 1, 0, -1};
  EXPECT_NE(VerdictOf(d, c), Verdict::kFelt) << "a force that never came";
}

TEST(FeelTest, AnAttachedUnitWhoseDelayNobodyMeasuredHasATickAndLessStiffness) {
  scene::DeviceProfile profile = Profile("omega3");
  Result<AttachedDevice> attached = Attached(profile);
  ASSERT_TRUE(attached.ok()) << attached.status().message();
  EXPECT_EQ(attached->device.delay_ticks, 1);
  EXPECT_EQ(attached->delay.from, scene::DelayUsed::From::kAssumed);
  EXPECT_DOUBLE_EQ(attached->device.kc_n_per_m, 2 * 6.0 * 1000 / 4);  // 2 b f/(d + 1)^2
  EXPECT_DOUBLE_EQ(AsItStands(profile)->kc_n_per_m, 10'000);
  profile.delay_measured = true;
  EXPECT_DOUBLE_EQ(Attached(profile)->device.kc_n_per_m, 10'000);
}

TEST(FeelTest, AProfileWithoutANumberIsRefusedByItsField) {
  scene::DeviceProfile profile = Profile("omega3");
  profile.resolution_nm.value = 0;
  EXPECT_EQ(AsItStands(profile).status().field(), "resolution_nm");
  EXPECT_EQ(Attached(profile).status().field(), "resolution_nm");
  profile = Profile("omega3");
  profile.damping_mn_s_per_m.value = 0;
  EXPECT_EQ(Attached(profile).status().code(), Code::kInvalidInput);
}

TEST(FeelTest, TheSameAgainIsTheSameToTheBit) {
  Device d = Attached(Profile("bhhd3"))->device;
  Cell a = Simulate(d, kEnamel, kCut, Motion::kStrokes),
       b = Simulate(d, kEnamel, kCut, Motion::kStrokes);
  EXPECT_EQ(a.law.error, b.law.error);
  EXPECT_EQ(a.law.gain, b.law.gain);
}

TEST(FeelTest, EveryThresholdHasItsSource) {
  ASSERT_EQ(Thresholds().size(), 3u);
  for (const Threshold& t : Thresholds()) EXPECT_FALSE(t.source.empty()) << t.name;
}

}  // namespace
}  // namespace enamel::fidelity
