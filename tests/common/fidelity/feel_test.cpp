#include "common/fidelity/feel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/fidelity/tracks.h"

namespace enamel::fidelity {
namespace {

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

TEST(FeelTest, TheStiffestGripIsReadBetweenThePoints) {
  const double grips[] = {300, 1000, 3000}, errors[] = {0.05, 0.10, 0.20};
  EXPECT_EQ(StiffestGrip(grips, errors, 0.04), 0);
  EXPECT_NEAR(StiffestGrip(grips, errors, 0.05), 300, 1e-9);
  EXPECT_NEAR(StiffestGrip(grips, errors, 0.15), std::sqrt(1000.0 * 3000), 1e-6);
  EXPECT_EQ(StiffestGrip(grips, errors, 0.25), 3000);
}

}  // namespace
}  // namespace enamel::fidelity
