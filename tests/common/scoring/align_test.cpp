#include "common/scoring/align.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace enamel::scoring {
namespace {

// The textbook recursion over the whole table, as an independent check.
double FullDtw(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<std::vector<double>> d(a.size(), std::vector<double>(b.size()));
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = 0; j < b.size(); ++j) {
      double best = i == 0 && j == 0 ? 0 : INFINITY;
      if (i > 0) best = std::min(best, d[i - 1][j]);
      if (j > 0) best = std::min(best, d[i][j - 1]);
      if (i > 0 && j > 0) best = std::min(best, d[i - 1][j - 1]);
      d[i][j] = best + std::fabs(a[i] - b[j]);
    }
  }
  return d.back().back();
}

Alignment Align(const std::vector<double>& a, const std::vector<double>& b, size_t band) {
  return AlignBanded(a.size(), b.size(), band,
                     [&](size_t i, size_t j) { return std::fabs(a[i] - b[j]); });
}

double TotalCost(const Alignment& alignment) {
  return alignment.mean_cost * static_cast<double>(alignment.path.size());
}

std::vector<double> Noise(size_t n, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<double> out(n);
  for (double& v : out) v = static_cast<double>(random() % 1000) / 100;
  return out;
}

void ExpectWholePath(const Alignment& alignment, size_t n, size_t m) {
  ASSERT_FALSE(alignment.path.empty());
  EXPECT_EQ(alignment.path.front(), std::make_pair(0u, 0u));
  EXPECT_EQ(alignment.path.back(),
            std::make_pair(static_cast<uint32_t>(n - 1), static_cast<uint32_t>(m - 1)));
  for (size_t k = 1; k < alignment.path.size(); ++k) {
    uint32_t di = alignment.path[k].first - alignment.path[k - 1].first;
    uint32_t dj = alignment.path[k].second - alignment.path[k - 1].second;
    EXPECT_TRUE(di <= 1 && dj <= 1 && di + dj >= 1);
  }
}

TEST(AlignBandedTest, EqualsTheFullTableWhenTheBandCoversIt) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    size_t n = 1 + seed % 13, m = 1 + (seed * 7) % 17;
    auto a = Noise(n, seed), b = Noise(m, seed + 100);
    Alignment alignment = Align(a, b, n + m);
    EXPECT_NEAR(TotalCost(alignment), FullDtw(a, b), 1e-9) << "seed " << seed;
    ExpectWholePath(alignment, n, m);
  }
}

TEST(AlignBandedTest, AnyBandGivesAWholePathThatIsNeverCheaperThanTheFullTable) {
  const std::pair<size_t, size_t> sizes[] = {{1, 1},  {1, 9},   {9, 1},   {40, 3},
                                             {3, 40}, {31, 29}, {100, 10}};
  for (auto [n, m] : sizes) {
    for (size_t band : {1u, 2u, 5u}) {
      auto a = Noise(n, 5), b = Noise(m, 6);
      Alignment alignment = Align(a, b, band);
      ExpectWholePath(alignment, n, m);
      EXPECT_GE(TotalCost(alignment), FullDtw(a, b) - 1e-9) << n << " x " << m << ", band " << band;
    }
  }
}

TEST(AlignBandedTest, ASeriesAgainstItselfCostsNothingAndRunsAlongTheDiagonal) {
  auto a = Noise(200, 3);
  Alignment alignment = Align(a, a, 20);
  EXPECT_EQ(alignment.mean_cost, 0);
  ASSERT_EQ(alignment.path.size(), 200u);
  for (uint32_t i = 0; i < 200; ++i) EXPECT_EQ(alignment.path[i], std::make_pair(i, i));
}

TEST(AlignBandedTest, APauseInOneSeriesCostsNothing) {
  std::vector<double> a, b;
  for (int i = 0; i < 50; ++i) a.push_back(i);
  b = a;
  b.insert(b.begin() + 25, 5, 25.0);  // stands still for five samples
  EXPECT_EQ(Align(a, b, 8).mean_cost, 0);
  EXPECT_GT(Align(a, b, 1).mean_cost, 0) << "a band narrower than the pause must cost something";
}

// The recursion of Eiter and Mannila's definition, over the whole table.
double FullFrechet(const std::vector<double>& a, const std::vector<double>& b, size_t i, size_t j) {
  const double here = std::fabs(a[i] - b[j]);
  if (i == 0 && j == 0) return here;
  if (i == 0) return std::max(here, FullFrechet(a, b, 0, j - 1));
  if (j == 0) return std::max(here, FullFrechet(a, b, i - 1, 0));
  return std::max(here, std::min({FullFrechet(a, b, i - 1, j), FullFrechet(a, b, i - 1, j - 1),
                                  FullFrechet(a, b, i, j - 1)}));
}

TEST(AlignBandedTest, TheWorstPairIsTheDiscreteFrechetDistance) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    const size_t n = 1 + seed % 7, m = 1 + (seed * 5) % 8;
    const auto a = Noise(n, seed), b = Noise(m, seed + 100);
    auto cost = [&](size_t i, size_t j) { return std::fabs(a[i] - b[j]); };
    const Alignment alignment = AlignBanded(n, m, n + m, cost, Pairing::kWorst);
    EXPECT_EQ(alignment.worst_cost, FullFrechet(a, b, n - 1, m - 1)) << seed;
    ExpectWholePath(alignment, n, m);
    EXPECT_GE(AlignBanded(n, m, n + m, cost).worst_cost, alignment.worst_cost);
  }
}

TEST(AlignBandedTest, AConstantOffsetIsTheMeanCost) {
  std::vector<double> a(30, 1.0), b(45, 3.5);
  EXPECT_DOUBLE_EQ(Align(a, b, 5).mean_cost, 2.5);
}

}  // namespace
}  // namespace enamel::scoring
