#include "common/scoring/movement/smoothness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace enamel::scoring {
namespace {

// Speed of a reach of least jerk over `length` in n samples (Flash and Hogan 1985).
std::vector<double> LeastJerk(size_t n, double length) {
  std::vector<double> out;
  for (size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n - 1);
    out.push_back(length * 30 * t * t * (1 - t) * (1 - t));
  }
  return out;
}

// The textbook sum over every frequency, with the library's functions.
double SlowSpectralArcLength(const std::vector<double>& v, double rate_hz) {
  size_t padded = 1;
  while (padded < v.size()) padded *= 2;
  padded *= 16;
  std::vector<double> amplitude;
  for (size_t k = 0; static_cast<double>(k) * rate_hz / static_cast<double>(padded) <= 10; ++k) {
    std::complex<double> sum = 0;
    for (size_t i = 0; i < v.size(); ++i) {
      sum += v[i] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k * i) /
                                        static_cast<double>(padded));
    }
    amplitude.push_back(std::abs(sum));
  }
  const double most = *std::max_element(amplitude.begin(), amplitude.end());
  size_t last = 0, first = amplitude.size();
  for (size_t k = 0; k < amplitude.size(); ++k) {
    if (amplitude[k] / most >= 0.05) last = k, first = std::min(first, k);
  }
  double length = 0;
  for (size_t k = first + 1; k <= last; ++k) {
    length +=
        std::hypot(1 / static_cast<double>(last - first), (amplitude[k] - amplitude[k - 1]) / most);
  }
  return -length;
}

TEST(SmoothnessTest, AReachOfLeastJerkHasItsKnownFigure) {
  // T^3 / v_max^2 times the integral of v''^2: 720 / 1.875^2 = 204.8.
  for (double length : {1e-3, 0.2}) {
    EXPECT_NEAR(*LogDimensionlessJerk(LeastJerk(5000, length)), -std::log(204.8), 2e-3);
  }
  EXPECT_NEAR(*LogDimensionlessJerk(LeastJerk(500, 1)), -std::log(204.8), 2e-2)
      << "neither size nor rate matters";
}

TEST(SmoothnessTest, StoppingOnTheWayIsLessSmooth) {
  std::vector<double> once = LeastJerk(200, 1), twice = LeastJerk(100, 0.5);
  const std::vector<double> second = LeastJerk(100, 0.5);
  twice.insert(twice.end(), second.begin(), second.end());
  EXPECT_LT(*LogDimensionlessJerk(twice), *LogDimensionlessJerk(once) - 0.5);
  EXPECT_LT(*SpectralArcLength(twice, 50), *SpectralArcLength(once, 50) - 0.1);
}

TEST(SmoothnessTest, SpectralArcLengthIsThatOfTheTextbookSum) {
  for (size_t n : {51u, 100u, 128u, 257u}) {
    std::vector<double> v = LeastJerk(n, 1);
    EXPECT_NEAR(*SpectralArcLength(v, 50), SlowSpectralArcLength(v, 50), 1e-9) << n;
    for (size_t i = 0; i < n; ++i)
      v[i] += 0.3 * std::pow(std::sin(0.37 * static_cast<double>(i)), 2);
    EXPECT_NEAR(*SpectralArcLength(v, 50), SlowSpectralArcLength(v, 50), 1e-9) << n;
    std::vector<double> scaled = v;
    for (double& x : scaled) x *= 8;
    EXPECT_EQ(*SpectralArcLength(scaled, 50), *SpectralArcLength(v, 50));
  }
}

TEST(SmoothnessTest, WhatDoesNotMoveHasNone) {
  const std::vector<double> still(100), even(100, 2.0), two = {1, 2};
  EXPECT_EQ(LogDimensionlessJerk(still), std::nullopt);
  EXPECT_EQ(LogDimensionlessJerk(even), std::nullopt);
  EXPECT_EQ(LogDimensionlessJerk(two), std::nullopt);
  EXPECT_EQ(SpectralArcLength(still, 50), std::nullopt);
  EXPECT_EQ(SpectralArcLength({}, 50), std::nullopt);
}

// Ten seconds of a sine along (1, 2, 2) / 3.
double TremorOfSine_m(uint32_t rate, double hz, double amplitude_m, double speed_m_s = 0) {
  TremorMeter meter(rate);
  for (uint32_t i = 0; i < 10 * rate; ++i) {
    const double t = i / static_cast<double>(rate);
    meter.Add(dvec3(1, 2, 2) / 3.0 * amplitude_m * std::sin(2 * std::numbers::pi * hz * t + 0.7) +
                  dvec3(0.01 + speed_m_s * t, 0, 0),
              true);
  }
  return *meter.Rms_m();
}

TEST(TremorMeterTest, ASineInTheBandHasItsRootMeanSquare) {
  for (uint32_t rate : {100u, 1000u, 4000u}) {
    for (double hz : {9.0, 10.0, 11.0}) {
      EXPECT_NEAR(TremorOfSine_m(rate, hz, 50e-6), 50e-6 / std::sqrt(2), 4e-9) << rate << " " << hz;
    }
  }
}

TEST(TremorMeterTest, WhatLiesOutsideTheBandIsNoTremor) {
  for (double hz : {0.0, 1.0, 3.0, 5.0, 15.0, 25.0, 40.0}) {
    EXPECT_LT(TremorOfSine_m(1000, hz, 50e-6), 0.2e-6) << hz;
  }
  EXPECT_LT(TremorOfSine_m(1000, 0, 0, 2e-3), 1.1e-6) << "a stroke at 2 mm/s";
}

TEST(TremorMeterTest, AWindowThatIsBrokenIsLeftOut) {
  TremorMeter meter(1000);
  for (int i = 0; i < 5000; ++i) meter.Add(dvec3(i % 7 * 1e-4), i % 999 != 0);
  EXPECT_EQ(meter.Rms_m(), std::nullopt);
}

}  // namespace
}  // namespace enamel::scoring
