#include "server/agreement/mean_squares.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace enamel::server {
namespace {

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

}  // namespace

Result<MeanSquares> MeanSquaresOf(const MarkTable& marks) {
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
  MeanSquares out{double(n), double(k), 0, 0, 0, mean};
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

}  // namespace enamel::server
