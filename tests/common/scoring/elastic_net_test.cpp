#include "common/scoring/mistakes/elastic_net.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

// The witness is the condition that holds at the least value alone: 0 is a subgradient. It is summed up here anew.
namespace enamel::scoring {
namespace {

struct Problem {
  std::vector<NetColumn> columns;
  std::vector<double> weights, d, lambdas;

  std::vector<double> Solved() const {
    std::vector<const NetColumn*> all;
    for (const NetColumn& column : columns) all.push_back(&column);
    return ElasticNet(all, weights, d, lambdas);
  }
};

// Columns that overlap, many of them alike, as motions of one surface are.
Problem Drawn(uint64_t seed) {
  std::mt19937_64 random(seed);
  auto uniform = [&](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  Problem out;
  constexpr uint32_t kRows = 120;
  for (uint32_t i = 0; i < kRows; ++i) {
    out.weights.push_back(uniform(0.001, 0.05));
    out.d.push_back(uniform(-0.2, 0.6));
  }
  for (int k = 0; k < 80; ++k) {
    NetColumn column;
    double square = 0;
    const double from = uniform(0, kRows), wide = uniform(4, 60), slope = uniform(-1, 1);
    for (uint32_t i = 0; i < kRows; ++i) {
      if (std::fabs(i - from) > wide) continue;
      const double phi = 1 + slope * (i - from) / wide;
      column.emplace_back(i, phi);
      square += out.weights[i] * phi * phi;
    }
    for (auto& [i, phi] : column) phi /= std::sqrt(square);
    out.columns.push_back(column);
    out.lambdas.push_back(uniform(0.01, 0.1));
  }
  return out;
}

TEST(ElasticNetTest, NoOtherSizesHaveASmallerSum) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem problem = Drawn(seed);
    const std::vector<double> beta = problem.Solved();
    std::vector<double> rest = problem.d;
    for (size_t k = 0; k < beta.size(); ++k) {
      for (const auto& [i, phi] : problem.columns[k]) rest[i] -= beta[k] * phi;
    }
    size_t used = 0;
    for (size_t k = 0; k < beta.size(); ++k) {
      double slope = -kRidge * beta[k];
      for (const auto& [i, phi] : problem.columns[k]) slope += problem.weights[i] * phi * rest[i];
      if (beta[k] == 0) {
        EXPECT_LE(std::fabs(slope), problem.lambdas[k] + 1e-6) << seed;
      } else {
        EXPECT_NEAR(slope, std::copysign(problem.lambdas[k], beta[k]), 1e-6) << seed;
        ++used;
      }
    }
    EXPECT_GT(used, 1U);
    EXPECT_LT(used, beta.size());
  }
}

}  // namespace
}  // namespace enamel::scoring
