#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "server/agreement/agreement.h"

namespace enamel::server {

Result<LimitsOfAgreement> BlandAltman(const std::vector<double>& first,
                                      const std::vector<double>& second) {
  if (first.size() != second.size() || first.size() < 3 || first.size() > kMaxMarkedWork) {
    return Status(Code::kInvalidInput, "expected 3 to 10000 pairs of marks");
  }
  const double n = double(first.size());
  double mean = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (!std::isfinite(first[i]) || !std::isfinite(second[i])) {
      return Status(Code::kInvalidInput, "expected marks that are numbers");
    }
    mean += (first[i] - second[i]) / n;
  }
  double squares = 0;
  for (size_t i = 0; i < first.size(); ++i) squares += std::pow(first[i] - second[i] - mean, 2);
  LimitsOfAgreement out;
  out.pairs = first.size();
  out.spread = std::sqrt(squares / (n - 1));
  // Student's and not the normal's: a class marks some dozen pieces of work twice.
  const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.975);
  const double bias_half = t * out.spread / std::sqrt(n);
  out.bias = {mean, {mean - bias_half, mean + bias_half}};
  // The variance of mean -+ 1.96 s is s^2 (1/n + 1.96^2 / (2 (n - 1))): mean and s are independent.
  constexpr double kNormal95 = 1.96;
  const double half = t * out.spread * std::sqrt(1 / n + kNormal95 * kNormal95 / (2 * (n - 1)));
  const double low = mean - kNormal95 * out.spread, high = mean + kNormal95 * out.spread;
  out.low = {low, {low - half, low + half}};
  out.high = {high, {high - half, high + half}};
  return out;
}

}  // namespace enamel::server
