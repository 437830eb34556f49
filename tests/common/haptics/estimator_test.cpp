#include "common/haptics/estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace enamel::haptics {
namespace {

constexpr double kTick = 1e-3, kDelta = 10e-6;

double Cell(double x) { return (std::floor(x / kDelta) + 0.5) * kDelta; }

std::unique_ptr<VelocityEstimator> Make(EstimatorKind kind, int window = 128) {
  EstimatorParams p;
  p.kind = kind;
  p.resolution_m = kDelta;
  p.window_ticks = window;
  return FindEstimator(kind)->make(p);
}

TEST(EstimatorTest, EveryEstimatorIsFoundByNameAndKind) {
  EXPECT_EQ(VelocityEstimators().size(), 7u);
  for (const EstimatorEntry& e : VelocityEstimators()) {
    EXPECT_EQ(FindEstimator(e.name), &e);
    EXPECT_EQ(FindEstimator(e.kind), &e);
  }
  EXPECT_EQ(FindEstimator("no such estimator"), nullptr);
}

// On an exact ramp all settle on its slope. Tolerances: rounding for the differences, the recursive
// filters' transient (exp(-2/0.02 s) and the Kalman's start) and Levant's chattering 1.1 L T.
TEST(EstimatorTest, ExactRampGivesItsSlope) {
  const double v = 3e-3;
  for (const EstimatorEntry& entry : VelocityEstimators()) {
    auto estimator = Make(entry.kind);
    estimator->Reset(0);
    double out = 0;
    for (int k = 1; k <= 2000; ++k) out = estimator->Update(v * kTick * k);
    double tolerance = entry.kind == EstimatorKind::kLevant ? 0.05 * v : 1e-6 * v;
    EXPECT_NEAR(out, v, tolerance) << entry.name;
  }
}

TEST(EstimatorTest, RestGivesZeroAndResetForgets) {
  for (const EstimatorEntry& entry : VelocityEstimators()) {
    auto estimator = Make(entry.kind);
    estimator->Reset(0);
    for (int k = 1; k <= 100; ++k) estimator->Update(5e-6 * k);
    estimator->Reset(1e-3);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(estimator->Update(1e-3), 0) << entry.name;
  }
}

// A parabola x = a t^2 / 2 through a window of n ticks: the mean speed a (t - nT/2), exactly.
TEST(EstimatorTest, WindowLagsAParabolaByHalfItsLength) {
  const double a = 0.02;
  const int n = 50;
  auto window = Make(EstimatorKind::kWindow, n);
  window->Reset(0);
  double out = 0;
  const int last = 400;
  for (int k = 1; k <= last; ++k) out = window->Update(0.5 * a * kTick * k * kTick * k);
  EXPECT_NEAR(out, a * (last - 0.5 * n) * kTick, 1e-12);
}

// The adaptive window keeps the parabola within delta of its line: through the end points the sag
// is a (nT)^2 / 8, so n T <= sqrt(8 delta / a) and the lag a n T / 2 <= sqrt(2 delta a).
TEST(EstimatorTest, AdaptiveWindowLagsAParabolaByNoMoreThanItsNoiseBandAllows) {
  const double a = 0.02;
  auto foaw = Make(EstimatorKind::kFoawEndFit, 256);
  foaw->Reset(0);
  double out = 0;
  for (int k = 1; k <= 400; ++k) out = foaw->Update(0.5 * a * kTick * k * kTick * k);
  double lag = a * 400 * kTick - out;
  EXPECT_LE(lag, std::sqrt(2 * kDelta * a) * 1.05);
  EXPECT_GE(lag, std::sqrt(2 * kDelta * a) * 0.8);
}

// Liu et al. eq. 7: one tick's difference is wrong by at most 2 delta f with |p - x| <= delta; cell
// middles have |p - x| <= delta/2 and so delta f. Over n ticks it is delta f / n. Both are reached.
TEST(EstimatorTest, QuantisedRampErrorIsBoundedByOneCellOverTheWindow) {
  const double v = 0.43e-3;
  for (int n : {1, 10, 128}) {
    auto window = Make(EstimatorKind::kWindow, n);
    window->Reset(Cell(0));
    double worst = 0;
    for (int k = 1; k <= 5000; ++k) {
      double out = window->Update(Cell(v * kTick * k));
      if (k > n) worst = std::max(worst, std::fabs(out - v));
    }
    double bound = kDelta / kTick / n;
    EXPECT_LE(worst, bound);
    EXPECT_LE(worst, 2 * kDelta / kTick);
    EXPECT_GE(worst, 0.5 * bound);
  }
}

// Over a full window of 256 ticks the slope through points within delta/2 of the ramp is within
// delta f / 256 of it; the best fit does better than the ends (variance 12/n^3 against 2/n^2).
TEST(EstimatorTest, BestFitIsSteadierThanEndFitOnAQuantisedRamp) {
  const double v = 0.43e-3;
  double rms[2] = {0, 0};
  for (int which : {0, 1}) {
    auto foaw = Make(which ? EstimatorKind::kFoawBestFit : EstimatorKind::kFoawEndFit, 256);
    foaw->Reset(Cell(0));
    for (int k = 1; k <= 6000; ++k) {
      double out = foaw->Update(Cell(v * kTick * k));
      if (k <= 1000) continue;
      EXPECT_LE(std::fabs(out - v), 2 * kDelta / kTick / 256) << k;
      rms[which] += (out - v) * (out - v);
    }
  }
  EXPECT_LT(rms[1], rms[0]);
}

TEST(EstimatorTest, AdaptiveWindowShrinksAtOnceWhenTheHandReverses) {
  auto foaw = Make(EstimatorKind::kFoawEndFit, 256);
  foaw->Reset(0);
  double out = 0;
  for (int k = 1; k <= 500; ++k) out = foaw->Update(20e-6 * k);
  for (int k = 1; k <= 3; ++k) out = foaw->Update(20e-6 * (500 - k));
  EXPECT_LT(out, 0);
}

// Step response of the bilinear low-pass to a ramp: v (1 - ((2 tau - T)/(2 tau + T))^k).
TEST(EstimatorTest, LowPassFollowsItsClosedForm) {
  auto lowpass = Make(EstimatorKind::kLowPass);
  lowpass->Reset(0);
  const double v = 1e-3, tau = 0.02, pole = (2 * tau - kTick) / (2 * tau + kTick);
  for (int k = 1; k <= 100; ++k) {
    EXPECT_NEAR(lowpass->Update(v * kTick * k), v * (1 - std::pow(pole, k)), 1e-12);
  }
}

// Kalata 1984: with tracking index lambda = sigma_a T^2 / sigma_n and
// r = (4 + lambda - sqrt(8 lambda + lambda^2)) / 4, alpha = 1 - r^2, beta = 2 (2 - alpha) - 4
// sqrt(1 - alpha): the settled filter answers a jump of the measurement by beta / T times its size
// in velocity.
TEST(EstimatorTest, KalmanGainsSettleOnKalatas) {
  EstimatorParams p;
  p.kind = EstimatorKind::kKalman;
  p.resolution_m = kDelta;
  auto kalman = MakeKalmanEstimator(p);
  kalman->Reset(0);
  for (int k = 0; k < 20000; ++k) kalman->Update(0);
  double lambda = p.acceleration_m_per_s2 * kTick * kTick / (kDelta / std::sqrt(12.0));
  double r = (4 + lambda - std::sqrt(8 * lambda + lambda * lambda)) / 4, alpha = 1 - r * r;
  double beta = 2 * (2 - alpha) - 4 * std::sqrt(1 - alpha);
  EXPECT_NEAR(kalman->Update(1e-6), beta / kTick * 1e-6, 1e-6 * beta / kTick * 1e-6);
}

// Levant's differentiator is exact for |x''| < L after a finite time, up to chattering of order L
// T.
TEST(EstimatorTest, LevantConvergesInFiniteTimeOnASmoothMotion) {
  EstimatorParams p;
  p.kind = EstimatorKind::kLevant;
  p.acceleration_m_per_s2 = 0.05;
  auto levant = MakeLevantEstimator(p);
  levant->Reset(0);
  const double amplitude = 1e-3, w = 5;  // x'' <= 0.025
  for (int k = 1; k <= 4000; ++k) {
    double t = kTick * k, out = levant->Update(amplitude * std::sin(w * t));
    if (t <= 2) continue;
    EXPECT_NEAR(out, amplitude * w * std::cos(w * t), 10 * p.acceleration_m_per_s2 * kTick) << t;
  }
}

}  // namespace
}  // namespace enamel::haptics
