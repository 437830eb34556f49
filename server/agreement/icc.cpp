#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <string>

#include "server/agreement/agreement.h"
#include "server/agreement/mean_squares.h"

namespace enamel::server {
namespace {

constexpr double kBeyond = 0.025;  // on either side of an interval of 95 %

double FQuantile(double d1, double d2) {
  return boost::math::quantile(
      boost::math::complement(boost::math::fisher_f_distribution<>(d1, d2), kBeyond));
}

}  // namespace

Agreement CutOff(const Agreement& coefficient) {
  // The room is for what 100 times .29 is short of 29.
  auto cut = [](double value) { return std::floor(100 * value + 1e-9) / 100; };
  return {cut(coefficient.value), {cut(coefficient.interval.low), cut(coefficient.interval.high)}};
}

MarkTable CompleteRows(const std::vector<std::vector<std::optional<double>>>& rows) {
  MarkTable out;
  for (const auto& row : rows) {
    std::vector<double> marks;
    for (const auto& mark : row) {
      if (mark) marks.push_back(*mark);
    }
    // Whole rows only: the analysis of variance has one mark in every cell.
    if (marks.size() == row.size()) out.push_back(std::move(marks));
  }
  return out;
}

Result<Agreement> Icc21(const MarkTable& marks) {
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, MeanSquaresOf(marks));
  const double n = s.n, k = s.k;
  const double value =
      (s.rows - s.rest) / (s.rows + (k - 1) * s.rest + k * (s.columns - s.rest) / n);
  if (s.rest == 0 && s.columns == 0) return Agreement{1, {1, 1}};
  // Satterthwaite's degrees of freedom of the sum of columns and rest, McGraw and Wong's table 7,
  // in a and b that stay finite when the rest is 0.
  const double a = k * value / (n * (1 - value));
  const double b = 1 + k * value * (n - 1) / (n * (1 - value));
  const double sum = a * s.columns + b * s.rest;
  const double freedom =
      sum * sum /
      (std::pow(a * s.columns, 2) / (k - 1) + std::pow(b * s.rest, 2) / ((n - 1) * (k - 1)));
  // With a value at or below 0 the sum may come to nothing: the least freedom is then meant.
  const double v = std::isfinite(freedom) && freedom > 1 ? freedom : 1;
  const double above = FQuantile(n - 1, v), below = FQuantile(v, n - 1);
  const double others = k * s.columns + (k * n - k - n) * s.rest;
  return Agreement{value,
                   {n * (s.rows - above * s.rest) / (above * others + n * s.rows),
                    n * (below * s.rows - s.rest) / (others + n * below * s.rows)}};
}

Result<Agreement> Icc3k(const MarkTable& marks) {
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, MeanSquaresOf(marks));
  if (s.rest == 0) return Agreement{1, {1, 1}};
  const double ratio = s.rows / s.rest;
  const double rest_freedom = (s.n - 1) * (s.k - 1);
  return Agreement{1 - 1 / ratio,
                   {1 - FQuantile(s.n - 1, rest_freedom) / ratio,
                    1 - 1 / (ratio * FQuantile(rest_freedom, s.n - 1))}};
}

}  // namespace enamel::server
