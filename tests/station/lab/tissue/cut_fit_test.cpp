#include "station/lab/tissue/cut_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "common/fidelity/plant.h"
#include "station/lab/tissue/fit_damping.h"
#include "tests/station/lab/tissue/recorded_cut.h"

namespace enamel::station::lab {

using fidelity::Random;
namespace {

namespace fs = std::filesystem;

// Recordings a claim is made of: fewer than `./check --full` takes.
const int kSeeds = std::getenv("ENAMEL_FULL") != nullptr ? 200 : 50;
constexpr double kSeconds = 20;

dmat3 Along(const dvec3& u, double s) { return dmat3(u * (u.x * s), u * (u.y * s), u * (u.z * s)); }

// Three axes of a turned frame.
const dvec3 kAxis = glm::normalize(dvec3(1, 2, 3)),
            kSide = glm::normalize(glm::cross(kAxis, dvec3(0, 0, 1))),
            kOther = glm::cross(kAxis, kSide);

// A hand that presses 1.2 s at a time in random directions, every third time too weakly to cut or
// hardly strongly enough.
std::function<dvec3(double)> Presses(uint64_t seed) {
  Random r(seed * 77 + 5);
  std::vector<dvec3> force;
  for (int i = 0; i < 60; ++i)
    force.push_back(r.Direction() * (i % 3 == 0 ? r.Between(0.4, 1.2) : r.Between(1.2, 4)));
  return [force](double t) {
    auto k = static_cast<size_t>(t / 1.2);
    double s = t - 1.2 * static_cast<double>(k);
    double rise = s < 0.2 ? s / 0.2 : s < 0.8 ? 1 : s < 1 ? (1 - s) / 0.2 : 0;
    return force[k % force.size()] * rise;
  };
}

// How often intervals hold the truth, and the errors of values.
struct Score {
  int n = 0, held = 0;
  double sum = 0, squares = 0, worst = 0, half = 0;
  void Add(const Estimate& e, double truth) {
    ++n;
    held += e.low <= truth && truth <= e.high;
    sum += e.value - truth;
    squares += (e.value - truth) * (e.value - truth);
    worst = std::max(worst, std::fabs(e.value - truth));
    half += (e.high - e.low) / 2;
  }
  double coverage() const { return static_cast<double>(held) / n; }
  double rms() const { return std::sqrt(squares / n); }
  void Print(const char* name, double truth) const {
    std::printf("%-22s truth %6.3f: held %.3f, bias %+.4f, rms %.4f, worst %.3f, half width %.3f\n",
                name, truth, coverage(), sum / n, rms(), worst, half / n);
  }
};

// The interval says 95 %; of 200, 186 or more, and of 50, 47.
void ExpectRecovered(const char* name, const Score& s, double truth, double rms_bound) {
  s.Print(name, truth);
  EXPECT_GE(s.coverage(), 0.93) << name;
  EXPECT_LT(s.rms(), rms_bound) << name;
}

// The threshold's interval holds the truth whether it was seen or only bounded; its value is judged
// where it was seen.
struct ThresholdScore {
  Score all, seen;
  void Add(const CutFit& f, double truth) {
    all.Add(f.threshold_n, truth);
    if (f.threshold_seen) seen.Add(f.threshold_n, truth);
  }
  void Expect(double truth) const {
    all.Print("Fth, seen or bounded", truth);
    std::printf("seen in %d of %d\n", seen.n, all.n);
    EXPECT_GE(all.coverage(), 0.93);
    ASSERT_GE(seen.n, all.n / 2);
    ExpectRecovered("Fth, seen", seen, truth, 0.1 * truth);
  }
};

TEST(CutFitTest, RecoversAnIsotropicTissueWithCoulombAndThreshold) {
  TrueCut truth{dmat3(6.5), 0.5, 0.9, 0};
  Score b, fc;
  ThresholdScore fth;
  for (uint64_t seed = 1; seed <= static_cast<uint64_t>(kSeeds); ++seed) {
    CutFit f = FitCut(CutByForce(truth, Sensor{}, kSeconds, seed, Presses(seed)), 1e-3, false, 3);
    ASSERT_EQ(f.refused, "");
    ASSERT_EQ(f.model, CutModel::kMatrix);
    b.Add(f.b, 6.5);
    fc.Add(f.coulomb_n, 0.5);
    fth.Add(f, 0.9);
  }
  ExpectRecovered("B", b, 6.5, 0.02 * 6.5);
  ExpectRecovered("Fc", fc, 0.5, 0.06 * 0.5);
  fth.Expect(0.9);
}

TEST(CutFitTest, RecoversDampingAlongAndAcrossTheBurFromItsAxis) {
  TrueCut truth{Along(kAxis, 9) + (dmat3(1) - Along(kAxis, 1)) * 5.0, 0.4, 0.8, 0};
  Score b, axial, fc;
  ThresholdScore fth;
  for (uint64_t seed = 1; seed <= static_cast<uint64_t>(kSeeds); ++seed) {
    auto cut = CutByForce(truth, Sensor{}, kSeconds, seed, Presses(seed));
    for (CutSample& s : cut) s.axis = kAxis;
    CutFit f = FitCut(cut, 1e-3, false, 3);
    ASSERT_EQ(f.model, CutModel::kAxialLateral);
    b.Add(f.b, 5);
    axial.Add(f.axial, 9);
    fc.Add(f.coulomb_n, 0.4);
    fth.Add(f, 0.8);
  }
  ExpectRecovered("B across", b, 5, 0.02 * 5);
  ExpectRecovered("B along", axial, 9, 0.02 * 9);
  ExpectRecovered("Fc", fc, 0.4, 0.06 * 0.4);
  fth.Expect(0.8);
}

TEST(CutFitTest, RecoversATurnedMatrixThroughNoiseSpikesAndMissingRows) {
  TrueCut truth{Along(kAxis, 9) + Along(kSide, 6) + Along(kOther, 3), 0.5, 0.9, 0};
  Sensor sensor;
  sensor.position_noise_mm = 0.005;
  sensor.force_noise_n = 0.1;
  sensor.dropped = 0.03;
  sensor.spikes = 0.001;
  constexpr int kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
  constexpr const char* kEntry[] = {"B xx", "B yy", "B zz", "B xy", "B xz", "B yz"};
  Score entry[6], fc;
  ThresholdScore fth;
  for (uint64_t seed = 1; seed <= static_cast<uint64_t>(kSeeds); ++seed) {
    CutFit f = FitCut(CutByForce(truth, sensor, kSeconds, seed, Presses(seed)), 1e-3, false, 3);
    ASSERT_EQ(f.model, CutModel::kMatrix);
    for (int j = 0; j < 6; ++j) entry[j].Add(f.matrix[j], truth.b[kRow[j]][kColumn[j]]);
    fc.Add(f.coulomb_n, 0.5);
    fth.Add(f, 0.9);
    EXPECT_GT(f.spikes, 0u);
    EXPECT_GT(f.principal[0], 0);
  }
  for (int j = 0; j < 6; ++j)
    ExpectRecovered(kEntry[j], entry[j], truth.b[kRow[j]][kColumn[j]], 0.03 * 6);
  ExpectRecovered("Fc", fc, 0.5, 0.08 * 0.5);
  fth.Expect(0.9);
}

TEST(CutFitTest, WithoutNoiseOnlyTheGatesOwnWidthRemains) {
  TrueCut truth{Along(kAxis, 9) + Along(kSide, 6) + Along(kOther, 3), 0.5, 0.9, 0};
  CutFit f =
      FitCut(CutByForce(truth, {1000, 0, 0, 0, 0, 0}, kSeconds, 1, Presses(1)), 1e-3, false, 3);
  EXPECT_NEAR(f.matrix[0].value, truth.b[0][0], 0.005 * 6);
  EXPECT_NEAR(f.matrix[3].value, truth.b[0][1], 0.005 * 6);
  EXPECT_NEAR(f.coulomb_n.value, 0.5, 0.01);
  ASSERT_TRUE(f.threshold_seen);
  EXPECT_NEAR(f.threshold_n.value, 0.9, 0.02);
}

TEST(CutFitTest, ABendingTipIsTakenOutOfTheMotion) {
  TrueCut truth{dmat3(6.5), 0.5, 0.9, 0.01};
  Score b, c;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    CutFit f = FitCut(CutByForce(truth, Sensor{}, kSeconds, seed, Presses(seed)), 1e-3, false, 3);
    b.Add(f.b, 6.5);
    c.Add(f.compliance_mm_per_n, 0.01);
  }
  b.Print("B", 6.5);
  c.Print("c", 0.01);
  EXPECT_LT(b.rms(), 0.02 * 6.5);
  EXPECT_LT(c.rms(), 0.1 * 0.01);
}

bool Warns(const CutFit& f, const char* of) {
  return std::any_of(f.warnings.begin(), f.warnings.end(),
                     [&](const std::string& w) { return w.find(of) != std::string::npos; });
}

TEST(CutFitTest, SaysWhatTheRecordingCannotTellApart) {
  TrueCut truth{Along(kAxis, 9) + Along(kSide, 6) + Along(kOther, 3), 0.5, 0.5, 0};
  // One direction: B along it, which is n'B n for a force along an eigenvector.
  CutFit line = FitCut(
      CutByForce(truth, Sensor{}, kSeconds, 1,
                 [](double t) { return kAxis * (2.5 + 1.5 * std::sin(2 * M_PI * 0.3 * t)); }),
      1e-3, false, 3);
  EXPECT_EQ(line.model, CutModel::kScalar);
  EXPECT_TRUE(Warns(line, "directions"));
  EXPECT_NEAR(line.b.value, 9, 0.3);
  EXPECT_NEAR(line.coulomb_n.value, 0.5, 0.1);
  // One speed too: one number contains both parts, F/V.
  CutFit speed = FitCut(
      CutByForce(truth, Sensor{}, kSeconds, 1, [](double) { return 2.5 * kAxis; }), 1e-3, false, 3);
  EXPECT_FALSE(speed.with_coulomb);
  EXPECT_TRUE(Warns(speed, "speeds are too much alike"));
  EXPECT_NEAR(speed.b.value, 2.5 / (2.0 / 9), 0.2);
  // Nothing that sticks.
  EXPECT_TRUE(Warns(line, "no sticking"));
  EXPECT_FALSE(line.threshold_seen);
}

TEST(CutFitTest, ForceOfTheToothOnTheHandIsTurned) {
  TrueCut truth{dmat3(6.5), 0.5, 0.5, 0};
  auto cut = CutByForce(truth, Sensor{}, kSeconds, 1, Presses(1));
  CutFit ours = FitCut(cut, 1e-3, false, 3);
  for (CutSample& s : cut) s.f_n = -s.f_n;
  CutFit theirs = FitCut(cut, 1e-3, false, 3);
  EXPECT_EQ(ours.b.value, theirs.b.value);
  EXPECT_TRUE(Warns(theirs, "turned"));
}

TEST(CutFitTest, FrontSpeedInvertsTheLawAndStopsAtCoulombsPart) {
  dmat3 basis(kAxis, kSide, kOther);
  Random r(3);
  for (int i = 0; i < 100; ++i) {
    dvec3 v = r.Direction() * r.LogBetween(1e-3, 10);
    dvec3 f = (Along(kAxis, 9) + Along(kSide, 6) + Along(kOther, 3)) * v + 0.5 * glm::normalize(v);
    EXPECT_LT(glm::length(FrontSpeed(f, basis, {9, 6, 3}, 0.5) - v), 1e-6 * glm::length(v));
  }
  EXPECT_EQ(glm::length(FrontSpeed({0.3, 0.3, 0.2}, basis, {9, 6, 3}, 0.5)), 0);
}

// Positions of a person's hand at 1 kHz, scaled down to a mean speed of 0.45 mm/s.
std::vector<dvec3> HumanPath_mm(const fs::path& file) {
  std::vector<dvec3> path;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    double t;
    dvec3 p;
    if (cells >> t >> p.x >> p.y >> p.z) path.push_back(p * 1e3);
  }
  // The robot's own noise would cut too, so this is a mean over 100 ms of the recording.
  std::vector<dvec3> smooth(path.size());
  for (size_t i = 0; i < path.size(); ++i) {
    size_t a = i < 50 ? 0 : i - 50, b = std::min(path.size(), i + 51);
    for (size_t k = a; k < b; ++k) smooth[i] += path[k] / static_cast<double>(b - a);
  }
  double length = 0;
  for (size_t i = 1; i < smooth.size(); ++i) length += glm::length(smooth[i] - smooth[i - 1]);
  double scale = 0.45 * static_cast<double>(smooth.size()) * 1e-3 / length;
  for (dvec3& p : smooth) p *= scale;
  return smooth;
}

TEST(CutFitTest, RecoversATissueCutAlongRecordedHands) {
  fs::path folder = fs::path(ENAMEL_SHARED_DATA) / "motion/panda";
  if (!fs::exists(folder)) GTEST_SKIP() << "skipped: no shared data";
  TrueCut truth{Along(kAxis, 8) + (dmat3(1) - Along(kAxis, 1)) * 6.0, 0.3, 0.5, 0.005};
  for (const char* name : {"rec1.csv", "rec2.csv", "rec3.csv"}) {
    std::vector<dvec3> path = HumanPath_mm(folder / name);
    ASSERT_GT(path.size(), 1000u);
    double seconds = static_cast<double>(path.size() - 2) * 1e-3;
    Score b, axial, fc;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      Sensor sensor;
      sensor.count_mm = 0.002;
      auto cut = CutByMotion(truth, sensor, seconds, seed, [&](double t) {
        double at = t * 1e3;
        auto i = std::min(static_cast<size_t>(at), path.size() - 2);
        return glm::mix(path[i], path[i + 1], at - static_cast<double>(i));
      });
      for (CutSample& s : cut) s.axis = kAxis;
      CutFit f = FitCut(cut, 1e-3, false, 3);
      ASSERT_EQ(f.refused, "") << name;
      b.Add(f.b, 6);
      axial.Add(f.axial, 8);
      fc.Add(f.coulomb_n, 0.3);
    }
    std::printf("%s, %.1f s\n", name, seconds);
    b.Print("B across", 6);
    axial.Print("B along", 8);
    fc.Print("Fc", 0.3);
    EXPECT_LT(b.rms(), 0.01 * 6) << name;
    EXPECT_LT(axial.rms(), 0.01 * 8) << name;
    EXPECT_LT(fc.rms(), 0.1 * 0.3) << name;
    EXPECT_GE(b.coverage(), 0.9) << name;
    EXPECT_GE(axial.coverage(), 0.9) << name;
  }
}

// Five loads, each for a while and in three directions across the bur: what a rig would do.
std::function<dvec3(double)> Loads(uint64_t seed) {
  Random r(seed * 31 + 3);
  std::vector<dvec3> force;
  for (int i = 0; i < 40; ++i) {
    const double angle = r.Between(0, 2 * M_PI);
    force.push_back(dvec3(std::cos(angle), std::sin(angle), 0) * (0.6 + 0.7 * (i % 5)));
  }
  return [force](double t) {
    const auto k = static_cast<size_t>(t / 1.2);
    const double s = t - 1.2 * static_cast<double>(k);
    const double rise = s < 0.2 ? s / 0.2 : s < 0.9 ? 1 : s < 1.1 ? (1.1 - s) / 0.2 : 0;
    return force[k % force.size()] * rise;
  };
}

// Recordings of tissue that is cut by load, and of tissue that is not, made by a code that shares none with the fit: the
// exponent is told right or not at all, and its numbers lie in their intervals.
TEST(LoadFitTest, TellsARootFromALineAndFindsItsNumbers) {
  int told = 0, wrong = 0, coulomb_held = 0, rate_held = 0, friction_held = 0, n = 0;
  for (int seed = 1; seed <= kSeeds / 2; ++seed) {
    for (bool root : {true, false}) {
      TrueCut truth;
      truth.coulomb_n = 0.2;
      truth.friction = 0.5;
      truth.b = dmat3(6.0);
      if (root) truth.root = 2.6 / std::sqrt(0.43);
      std::vector<CutSample> samples = CutByForce(truth, {}, 40, static_cast<uint64_t>(seed),
                                                  Loads(static_cast<uint64_t>(seed)));
      for (CutSample& s : samples) s.axis = dvec3(0, 0, 1);
      const CutFit fit = FitCut(samples, 1e-3, false, 3);
      ASSERT_TRUE(fit.refused.empty()) << fit.refused;
      const LoadFit load = FitLoad(fit.feeds);
      told += load.exponent_told;
      wrong += load.exponent_told && root != (load.exponent == cutting::FeedExponent::kHalf);
      friction_held += load.friction.low <= 0.5 && 0.5 <= load.friction.high;
      EXPECT_NEAR(load.friction.value, 0.5, 0.05);
      if (!root || !load.exponent_told) continue;
      ++n;
      const double rate = truth.root * std::sqrt(load.feed_mm_s);
      EXPECT_NEAR(load.at_feed_n.value, rate, 0.1 * rate);
      coulomb_held += load.coulomb_n.low <= 0.2 && 0.2 <= load.coulomb_n.high;
      rate_held += load.at_feed_n.low <= rate && rate <= load.at_feed_n.high;
    }
  }
  const int all = kSeeds / 2 * 2;
  std::printf(
      "exponent told in %d of %d, wrong in %d; of %d roots the interval holds Coulomb's part in "
      "%d, the rest in "
      "%d; friction in %d of %d\n",
      told, all, wrong, n, coulomb_held, rate_held, friction_held, all);
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(told, 0.85 * all);
  EXPECT_GE(coulomb_held, 0.8 * n);
  EXPECT_GE(rate_held, 0.8 * n);
}

// Two loads that are nearly alike hold no exponent, and a magnitude no friction: both are said.
TEST(LoadFitTest, SaysWhatTheRecordingDoesNotHold) {
  std::vector<CutPoint> points;
  for (int i = 0; i < 60; ++i)
    points.push_back({0.40 + 0.001 * (i % 20), 2.7 + 0.01 * (i % 7), {}});
  const LoadFit fit = FitLoad(points);
  EXPECT_FALSE(fit.exponent_told);
  EXPECT_NE(fit.why_no_exponent.find("factor of two"), std::string::npos);
  EXPECT_EQ(fit.exponent, cutting::FeedExponent::kOne);
  EXPECT_FALSE(fit.friction_told);
}

}  // namespace
}  // namespace enamel::station::lab
