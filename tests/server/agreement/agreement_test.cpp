#include "server/agreement/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace enamel::server {
namespace {

// Shrout and Fleiss 1979, table 2: six targets, four judges.
const MarkTable kShroutFleiss = {{9, 2, 5, 8}, {6, 1, 3, 2},  {8, 4, 6, 8},
                                 {7, 1, 2, 6}, {10, 5, 6, 9}, {6, 2, 4, 7}};

// Their table 4 gives .29 and .91; the intervals are worked out from the mean squares they print
// (table 3: 11.24, 32.49, 1.02) with tables of F: F(.975; 5, 15) = 3.576, F(.975; 15, 5) = 6.428.
TEST(AgreementTest, ShroutAndFleissExampleIsFound) {
  auto single = Icc21(kShroutFleiss);
  ASSERT_TRUE(single.ok());
  EXPECT_NEAR(single->value, 0.29, 0.005);
  // As the packages psych and irr of R print it: .019 to .761.
  EXPECT_NEAR(single->interval.low, 0.019, 0.001);
  EXPECT_NEAR(single->interval.high, 0.761, 0.001);
  auto mean = Icc3k(kShroutFleiss);
  ASSERT_TRUE(mean.ok());
  EXPECT_NEAR(mean->value, 0.91, 0.005);
  EXPECT_NEAR(mean->interval.low, 1 - 3.576 / (11.24 / 1.02), 0.002);
  EXPECT_NEAR(mean->interval.high, 1 - 1 / (11.24 / 1.02 * 6.428), 0.002);
}

TEST(AgreementTest, AStricterMarkerCountsForTheSingleMarkAndNotForTheOrder) {
  const MarkTable marks = {{10, 5}, {20, 15}, {30, 25}, {45, 40}};
  EXPECT_EQ(Icc3k(marks)->value, 1);
  auto single = Icc21(marks);
  ASSERT_TRUE(single.ok());
  EXPECT_LT(single->value, 0.97);
  EXPECT_GT(single->value, 0.9);
  EXPECT_EQ(Icc21({{10, 10}, {20, 20}, {30, 30}})->value, 1);
}

// The interval holds the true figure as often as it says: marks drawn from the model itself.
TEST(AgreementTest, IntervalsHoldTheTruthAsOftenAsTheySay) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  int single_held = 0, mean_held = 0, limits_held = 0;
  const int runs = 1000, n = 12, k = 3;
  const double work = 2, marker = 0.7, rest = 1;
  for (int run = 0; run < runs; ++run) {
    MarkTable marks(n, std::vector<double>(k));
    std::vector<double> strict(k);
    for (double& s : strict) s = marker * normal(random);
    std::vector<double> first, second;
    for (auto& row : marks) {
      const double level = work * normal(random);
      for (int j = 0; j < k; ++j) row[j] = level + strict[j] + rest * normal(random);
      first.push_back(normal(random));
      second.push_back(normal(random));
    }
    const double true_single = work * work / (work * work + marker * marker + rest * rest);
    const double true_mean = work * work / (work * work + rest * rest / k);
    auto holds = [](const Agreement& a, double truth) {
      return a.interval.low <= truth && truth <= a.interval.high;
    };
    single_held += holds(*Icc21(marks), true_single);
    mean_held += holds(*Icc3k(marks), true_mean);
    limits_held += holds(BlandAltman(first, second)->high, 1.96 * std::sqrt(2.0));
  }
  // 95 % of 1000 has a standard deviation of 7; the first and the last are approximations.
  EXPECT_NEAR(single_held, 950, 25);
  EXPECT_NEAR(mean_held, 950, 25);
  EXPECT_NEAR(limits_held, 950, 25);
}

// Cohen 1968, table 1: shares of 200 patients in three classes, weights 0, 1, 3 / 1, 0, 6 / 3, 6,
// 0: kappa .492, weighted .348.
TEST(AgreementTest, CohensExampleIsFound) {
  const std::vector<std::vector<double>> counts = {{88, 10, 2}, {14, 40, 6}, {18, 10, 12}};
  auto plain = WeightedKappa(counts, KappaWeights::kNone);
  ASSERT_TRUE(plain.ok());
  EXPECT_NEAR(plain->value, 0.492, 0.0005);
  auto weighted = WeightedKappa(counts, {{0, 1, 3}, {1, 0, 6}, {3, 6, 0}});
  ASSERT_TRUE(weighted.ok());
  EXPECT_NEAR(weighted->value, 0.348, 0.0005);
  EXPECT_LT(weighted->interval.low, weighted->value);
  // The order of the markers does not matter.
  EXPECT_NEAR(
      WeightedKappa(counts, KappaWeights::kQuadratic)->value,
      WeightedKappa({{88, 14, 18}, {10, 40, 10}, {2, 6, 12}}, KappaWeights::kQuadratic)->value,
      1e-12);
}

// Fleiss, Cohen and Everitt 1969: the error of weighted kappa against drawing again and again.
TEST(AgreementTest, ErrorOfKappaIsTheSpreadOfDraws) {
  const std::vector<double> shares = {.30, .08, .02, .06, .25, .07, .01, .06, .15};
  std::mt19937_64 random(3);
  std::discrete_distribution<int> cell(shares.begin(), shares.end());
  double sum = 0, squares = 0;
  const int draws = 2000, n = 200;
  for (int d = 0; d < draws; ++d) {
    std::vector<std::vector<double>> counts(3, std::vector<double>(3));
    for (int i = 0; i < n; ++i) {
      const int c = cell(random);
      counts[c / 3][c % 3] += 1;
    }
    const double kappa = WeightedKappa(counts, KappaWeights::kLinear)->value;
    sum += kappa;
    squares += kappa * kappa;
  }
  const double spread = std::sqrt(squares / draws - sum / draws * sum / draws);
  std::vector<std::vector<double>> expected(3, std::vector<double>(3));
  for (int c = 0; c < 9; ++c) expected[c / 3][c % 3] = n * shares[c];
  const Agreement a = *WeightedKappa(expected, KappaWeights::kLinear);
  EXPECT_NEAR((a.interval.high - a.interval.low) / (2 * 1.96), spread, 0.05 * spread);
}

// The table of J. L. Fleiss 1971 as often reprinted: 14 people put ten things into five classes;
// the mean share of pairs that agree is .378, from which (.378 - .2) / .8.
TEST(AgreementTest, FreeMarginalKappaIsFoundFromTheShareOfPairs) {
  auto kappa = FreeMarginalKappa({{0, 0, 0, 0, 14},
                                  {0, 2, 6, 4, 2},
                                  {0, 0, 3, 5, 6},
                                  {0, 3, 9, 2, 0},
                                  {2, 2, 8, 1, 1},
                                  {7, 7, 0, 0, 0},
                                  {3, 2, 6, 3, 0},
                                  {2, 5, 3, 2, 2},
                                  {6, 5, 2, 1, 0},
                                  {0, 2, 2, 3, 7}});
  ASSERT_TRUE(kappa.ok());
  EXPECT_NEAR(kappa->value, (0.378 - 0.2) / 0.8, 0.001);
  EXPECT_LT(kappa->interval.low, kappa->value);
  EXPECT_GT(kappa->interval.high, kappa->value);
}

// Bland and Altman 1986: peak flow of 17 people by a large and a small meter, l/min. They print a
// mean of -2.1 and a standard deviation of 38.8, limits of -79.7 and 75.5 (from 2 s), and -22.0 to
// 17.8 for the mean.
TEST(AgreementTest, BlandAndAltmansExampleIsFound) {
  auto limits = BlandAltman(
      {494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427},
      {512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451});
  ASSERT_TRUE(limits.ok());
  EXPECT_NEAR(limits->bias.value, -2.1, 0.05);
  EXPECT_NEAR(limits->spread, 38.8, 0.05);
  EXPECT_NEAR(limits->bias.interval.low, -22.0, 0.1);
  EXPECT_NEAR(limits->bias.interval.high, 17.8, 0.1);
  EXPECT_NEAR(limits->low.value, -2.1 - 1.96 * 38.8, 0.1);
  EXPECT_NEAR(limits->high.value, -2.1 + 1.96 * 38.8, 0.1);
  EXPECT_NEAR(limits->high.interval.high - limits->high.interval.low,
              2 * 2.12 * 38.8 * std::sqrt(1 / 17.0 + 1.96 * 1.96 / 32), 0.2);
}

TEST(AgreementTest, WhatHasNoValueIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Icc21({}).ok());
  EXPECT_FALSE(Icc21({{1, 2}}).ok());
  EXPECT_FALSE(Icc21({{1}, {2}}).ok());
  EXPECT_FALSE(Icc21({{1, 2}, {3}}).ok());
  EXPECT_FALSE(Icc21({{1, nan}, {3, 4}}).ok());
  EXPECT_FALSE(Icc21({{5, 5}, {5, 5}}).ok());
  EXPECT_FALSE(Icc3k({{0.1, 0.3}, {0.1, 0.3}, {0.1, 0.3}}).ok());
  EXPECT_FALSE(WeightedKappa({}, KappaWeights::kLinear).ok());
  EXPECT_FALSE(WeightedKappa({{5, 0}, {0, 0}}, KappaWeights::kLinear).ok());
  EXPECT_FALSE(WeightedKappa({{5, -1}, {0, 2}}, KappaWeights::kLinear).ok());
  EXPECT_FALSE(WeightedKappa({{5, 1}, {0, 2}, {1, 1}}, KappaWeights::kLinear).ok());
  EXPECT_FALSE(WeightedKappa({{5, 1}, {0, 2}}, {{0, 0}, {0, 0}}).ok());
  EXPECT_FALSE(FreeMarginalKappa({{1, 0}, {0, 1}}).ok());
  EXPECT_FALSE(FreeMarginalKappa({{2, 0}, {0, 1}}).ok());
  EXPECT_FALSE(BlandAltman({1, 2}, {1, 2}).ok());
  EXPECT_FALSE(BlandAltman({1, 2, 3}, {1, 2}).ok());
}

// Two people, nearly alike or opposed: figures and intervals stay finite, and in order.
TEST(AgreementTest, IntervalsAreInOrderWhateverTheMarks) {
  std::mt19937_64 random(11);
  for (int run = 0; run < 3000; ++run) {
    const size_t n = 2 + random() % 6, k = 2 + random() % 4;
    MarkTable marks(n, std::vector<double>(k));
    for (auto& row : marks) {
      for (double& mark : row) mark = double(random() % 4) * (run % 3 == 0 ? 1e6 : 1);
    }
    for (auto figure : {Icc21(marks), Icc3k(marks)}) {
      if (!figure.ok()) continue;
      EXPECT_TRUE(std::isfinite(figure->value));
      EXPECT_LE(figure->value, 1);
      EXPECT_LE(figure->interval.low, figure->value + 1e-9);
      EXPECT_GE(figure->interval.high, figure->value - 1e-9);
      EXPECT_LE(figure->interval.high, 1);
    }
  }
}

TEST(AgreementTest, WorkThatSomebodyDidNotMarkIsLeftOut) {
  EXPECT_EQ(CompleteRows({{1, 2}, {std::nullopt, 3}, {4, 5}}), (MarkTable{{1, 2}, {4, 5}}));
}

TEST(AgreementTest, WhatIsAlmostPerfectIsNotShownAsPerfect) {
  const Agreement shown = CutOff({.996, {.29, 1}});
  EXPECT_DOUBLE_EQ(shown.value, .99);
  EXPECT_DOUBLE_EQ(shown.interval.low, .29);
  EXPECT_DOUBLE_EQ(shown.interval.high, 1);
}

}  // namespace
}  // namespace enamel::server
