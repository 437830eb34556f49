#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/math/feed_force.h"
#include "common/math/log.h"
#include "common/math/orientation.h"
#include "common/math/sym3.h"
#include "common/math/trig.h"

namespace enamel {
namespace {

TEST(LogTest, IsTheLogarithmToTheLastBits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-300, 300), near(-0.4, 0.4);
  for (int i = 0; i < 200'000; ++i) {
    const double x = i % 2 == 0 ? std::pow(10, exponent(random)) : 1 + near(random);
    const double exact = std::log(x);
    EXPECT_NEAR(NaturalLog(x), exact, 1e-15 * std::fabs(exact)) << x;
  }
  EXPECT_EQ(NaturalLog(1), 0);
  EXPECT_EQ(NaturalLog(2), 0.69314718055994530942);
}

TEST(TrigTest, AgreesWithLibmToItsRounding) {
  for (int i = 0; i <= 10000; ++i) {
    double turns = i / 10000.0;
    SinCos t = SinCosOfTurns(turns);
    EXPECT_NEAR(t.sin, std::sin(2 * M_PI * turns), 1e-15);
    EXPECT_NEAR(t.cos, std::cos(2 * M_PI * turns), 1e-15);
  }
}

TEST(Sym3Test, SolveShiftedSatisfiesItsEquationOverElevenDecades) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (double scale : {1e-3, 1.0, 1e4, 1e8}) {
    for (int i = 0; i < 200; ++i) {
      // Sum of outer products: positive semi-definite, often singular.
      Sym3 a;
      for (int k = 0; k < 1 + i % 4; ++k) {
        a += Sym3::Outer(dvec3(normal(random), normal(random), normal(random)), scale);
      }
      dvec3 v(normal(random), normal(random), normal(random));
      double s = 2.5;
      dvec3 x = SolveShifted(a, s, v);
      dvec3 back = a * x + x * s;
      EXPECT_LT(glm::length(back - v), 1e-15 * (scale + 1) * 1e3 + 1e-9) << scale;
      EXPECT_TRUE(a.IsPositiveSemiDefinite(1e-9));
    }
  }
}

TEST(Sym3Test, IndefiniteMatrixIsRecognised) {
  EXPECT_FALSE((Sym3{1, 1, -0.1, 0, 0, 0}).IsPositiveSemiDefinite(1e-9));
  EXPECT_FALSE((Sym3{1, 1, 1, 2, 0, 0}).IsPositiveSemiDefinite(1e-9));
}

TEST(OrientationTest, QuantisedFormComesBackWithinItsResolution) {
  Quat q = Quat{0.1, -0.2, 0.3, 0.9}.Normalised();
  Quat back = FromQuantised(ToQuantised(q));
  EXPECT_NEAR(back.x, q.x, 2e-5);
  EXPECT_NEAR(back.w, q.w, 2e-5);
}

TEST(OrientationTest, MatrixRotatesAsTheQuaternionDoes) {
  // A quarter turn about z takes x to y.
  Quat q{0, 0, std::sqrt(0.5), std::sqrt(0.5)};
  dvec3 x = q.Matrix()[0];
  EXPECT_NEAR(x.x, 0, 1e-15);
  EXPECT_NEAR(x.y, 1, 1e-15);
}

TEST(OrientationTest, ZeroQuaternionMeansTheIdentity) {
  EXPECT_EQ(FromQuantised({0, 0, 0, 0}).w, 1);
}

// Against the root of K (L - w) = F(w/dt), halved down to in long double; and no two stretches lead to feeds that are
// farther apart. Over every size that a device and a tissue can have, and far beyond.
TEST(FeedForceTest, FeedIsTheOneThatTheForceBalances) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  auto size = [&](double lo, double hi) {
    return std::exp(std::log(lo) + any(random) * std::log(hi / lo));
  };
  for (int i = 0; i < 20'000; ++i) {
    const double k = size(1, 1e6), dt = size(1e-5, 1e-2), stretch = size(1e-9, 1e-1);
    FeedForce f{any(random) < 0.3 ? 0 : size(1e-4, 1e3), any(random) < 0.3 ? 0 : size(1e-2, 1e6),
                any(random) < 0.3 ? 0 : size(1e-2, 1e9)};
    const double w = FeedUnder(k, stretch, dt, f);
    long double lo = 0, hi = stretch;
    for (int step = 0; step < 200; ++step) {
      const long double at = (lo + hi) / 2, feed = at / dt;
      const long double left = k * (stretch - at) - f.coulomb_n -
                               f.root_n_sqrt_s_per_m * std::sqrt(feed) - f.linear_n_s_per_m * feed;
      (left > 0 ? lo : hi) = at;
    }
    ASSERT_NEAR(w, static_cast<double>(lo), 1e-12 * stretch + 1e-9 * static_cast<double>(lo)) << i;
    const double longer = stretch * (1 + any(random));
    const double w2 = FeedUnder(k, longer, dt, f);
    ASSERT_GE(w2, w) << i;
    ASSERT_LE(w2 - w, (longer - stretch) * (1 + 1e-9) + 1e-12 * longer) << i;
  }
}

TEST(TrigTest, ArcTanIsTheAngleOfASlopeAndOddAboutZero) {
  EXPECT_EQ(ArcTan(0), 0);
  for (double slope = 1e-9; slope < 1e9; slope *= 1.37) {
    EXPECT_NEAR(ArcTan(slope), std::atan(slope), 1e-15 * (1 + std::atan(slope))) << slope;
    EXPECT_EQ(ArcTan(-slope), -ArcTan(slope));
  }
}

}  // namespace
}  // namespace enamel
