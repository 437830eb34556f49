#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <string>

#include "server/agreement/agreement.h"

namespace enamel::server {
namespace {

constexpr double kBeyond = 0.025;  // on either side of an interval of 95 %

double FQuantile(double d1, double d2) {
  return boost::math::quantile(
      boost::math::complement(boost::math::fisher_f_distribution<>(d1, d2), kBeyond));
}

// Analysis of variance with one mark a cell.
struct MeanSquares {
  double n = 0, k = 0;
  double rows = 0, columns = 0, rest = 0;
};

Status CheckTable(const MarkTable& marks) {
  if (marks.size() < 2 || marks[0].size() < 2) {
    return {Code::kInvalidInput, "expected two pieces of work marked by two people at least"};
  }
  if (marks.size() > kMaxMarkedWork || marks[0].size() > kMaxMarkers) {
    return {Code::kInvalidInput, "expected at most " + std::to_string(kMaxMarkedWork) +
                                     " pieces of work and " + std::to_string(kMaxMarkers) +
                                     " people"};
  }
  for (const auto& row : marks) {
    if (row.size() != marks[0].size()) {
      return {Code::kInvalidInput, "expected a mark by each person for each piece of work"};
    }
    for (double mark : row) {
      if (!std::isfinite(mark)) return {Code::kInvalidInput, "expected marks that are numbers"};
    }
  }
  return {};
}

Result<MeanSquares> Analyse(const MarkTable& marks) {
  ENAMEL_RETURN_IF_ERROR(CheckTable(marks));
  const size_t n = marks.size(), k = marks[0].size();
  std::vector<double> row_mean(n), column_mean(k);
  double mean = 0;
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < k; ++j) {
      row_mean[i] += marks[i][j] / double(k);
      column_mean[j] += marks[i][j] / double(n);
    }
    mean += row_mean[i] / double(n);
  }
  MeanSquares out{double(n), double(k), 0, 0, 0};
  for (size_t i = 0; i < n; ++i) {
    out.rows += double(k) * std::pow(row_mean[i] - mean, 2) / double(n - 1);
    for (size_t j = 0; j < k; ++j) {
      const double rest = marks[i][j] - row_mean[i] - column_mean[j] + mean;
      out.rest += rest * rest / double((n - 1) * (k - 1));
    }
  }
  for (double m : column_mean) out.columns += double(n) * std::pow(m - mean, 2) / double(k - 1);
  // Rounding leaves some 1e-30 where marks agree to the last; a ratio of such is no figure.
  const double largest = std::max(std::abs(mean), std::sqrt(out.rows + out.columns));
  const double none = 1e-24 * largest * largest;
  if (out.rest < none) out.rest = 0;
  if (out.columns < none) out.columns = 0;
  if (out.rows <= none) {
    return Status(Code::kInvalidInput,
                  "expected work that is marked differently; all has the same mean mark, so that "
                  "a correlation has no value");
  }
  return out;
}

}  // namespace

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
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, Analyse(marks));
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
  ENAMEL_ASSIGN_OR_RETURN(const MeanSquares s, Analyse(marks));
  if (s.rest == 0) return Agreement{1, {1, 1}};
  const double ratio = s.rows / s.rest;
  const double rest_freedom = (s.n - 1) * (s.k - 1);
  return Agreement{1 - 1 / ratio,
                   {1 - FQuantile(s.n - 1, rest_freedom) / ratio,
                    1 - 1 / (ratio * FQuantile(rest_freedom, s.n - 1))}};
}

}  // namespace enamel::server
