#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "server/agreement/agreement.h"

namespace enamel::server {
namespace {

constexpr double kNormal95 = 1.959963984540054;

// The sum of all; errors where it is no table of counts.
Result<double> SumOf(const std::vector<std::vector<double>>& counts) {
  double sum = 0;
  for (const auto& row : counts) {
    if (row.size() != counts[0].size() || row.size() < 2 || row.size() > kMaxClasses) {
      return Status(Code::kInvalidInput, "expected 2 to 20 classes, the same in every row");
    }
    for (double count : row) {
      if (!std::isfinite(count) || count < 0) {
        return Status(Code::kInvalidInput, "expected counts of 0 and more");
      }
      sum += count;
    }
  }
  if (sum <= 0) return Status(Code::kInvalidInput, "expected marks, found none");
  return sum;
}

}  // namespace

Result<Agreement> WeightedKappa(const std::vector<std::vector<double>>& counts,
                                KappaWeights weights) {
  std::vector<std::vector<double>> w(counts.size(), std::vector<double>(counts.size()));
  for (size_t i = 0; i < counts.size(); ++i) {
    for (size_t j = 0; j < counts.size(); ++j) {
      const double apart = std::abs(double(i) - double(j));
      w[i][j] = weights == KappaWeights::kLinear      ? apart
                : weights == KappaWeights::kQuadratic ? apart * apart
                                                      : double(i != j);
    }
  }
  return WeightedKappa(counts, w);
}

Result<Agreement> WeightedKappa(const std::vector<std::vector<double>>& counts,
                                const std::vector<std::vector<double>>& disagreement) {
  const size_t q = counts.size();
  ENAMEL_ASSIGN_OR_RETURN(const double sum, SumOf(counts));
  if (counts[0].size() != q || disagreement.size() != q) {
    return Status(Code::kInvalidInput, "expected as many rows as classes");
  }
  double largest = 0;
  for (size_t i = 0; i < q; ++i) {
    if (disagreement[i].size() != q || disagreement[i][i] != 0) {
      return Status(Code::kInvalidInput, "expected weights for each pair of classes, 0 for equal");
    }
    for (double w : disagreement[i]) {
      if (!(w >= 0) || !std::isfinite(w)) {
        return Status(Code::kInvalidInput, "expected weights of 0 and more");
      }
      largest = std::max(largest, w);
    }
  }
  if (largest == 0) return Status(Code::kInvalidInput, "expected a weight above 0");

  // Fleiss, Cohen and Everitt's error is written for weights of agreement, 1 on the diagonal.
  auto agree = [&](size_t i, size_t j) { return 1 - disagreement[i][j] / largest; };
  std::vector<double> first(q), second(q);  // shares of each class
  for (size_t i = 0; i < q; ++i) {
    for (size_t j = 0; j < q; ++j) {
      first[i] += counts[i][j] / sum;
      second[j] += counts[i][j] / sum;
    }
  }
  double found = 0, chance = 0;
  std::vector<double> first_mean(q), second_mean(q);  // weight a class has with the other's shares
  for (size_t i = 0; i < q; ++i) {
    for (size_t j = 0; j < q; ++j) {
      found += agree(i, j) * counts[i][j] / sum;
      chance += agree(i, j) * first[i] * second[j];
      first_mean[i] += agree(i, j) * second[j];
      second_mean[j] += agree(i, j) * first[i];
    }
  }
  // By chance alone they would agree always: nothing is left to compare with.
  if (1 - chance < 1e-12) {
    return Status(Code::kInvalidInput,
                  "expected marks in two classes at least; with all in one, kappa has no value");
  }
  const double kappa = (found - chance) / (1 - chance);
  double variance = 0;
  for (size_t i = 0; i < q; ++i) {
    for (size_t j = 0; j < q; ++j) {
      const double part = agree(i, j) - (first_mean[i] + second_mean[j]) * (1 - kappa);
      variance += counts[i][j] / sum * part * part;
    }
  }
  variance -= std::pow(kappa - chance * (1 - kappa), 2);
  const double error = std::sqrt(std::max(variance, 0.0) / sum) / (1 - chance);
  return Agreement{
      kappa, {std::max(kappa - kNormal95 * error, -1.0), std::min(kappa + kNormal95 * error, 1.0)}};
}

Result<Agreement> FreeMarginalKappa(const std::vector<std::vector<double>>& counts) {
  if (counts.size() < 2 || counts.size() > kMaxMarkedWork) {
    return Status(Code::kInvalidInput, "expected 2 to 10000 pieces of work");
  }
  ENAMEL_ASSIGN_OR_RETURN(const double sum, SumOf(counts));
  const double n = double(counts.size()), classes = double(counts[0].size());
  // A mean of the rows. Where one differs from it, the marks are refused below.
  const double markers = sum / n;
  if (markers < 2) return Status(Code::kInvalidInput, "expected two people at least");
  std::vector<double> shares;
  double mean = 0;
  for (const auto& row : counts) {
    double here = 0, pairs = 0;
    for (double count : row) {
      here += count;
      pairs += count * (count - 1);
    }
    if (here != markers) {
      return Status(Code::kInvalidInput, "expected the same number of marks for each piece");
    }
    shares.push_back(pairs / (markers * (markers - 1)));
    mean += shares.back() / n;
  }
  double squares = 0;
  for (double share : shares) squares += (share - mean) * (share - mean);
  const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.975);
  const double half = t * std::sqrt(squares / (n - 1) / n);
  auto kappa = [&](double share) { return (share - 1 / classes) / (1 - 1 / classes); };
  return Agreement{kappa(mean),
                   {kappa(std::max(mean - half, 0.0)), kappa(std::min(mean + half, 1.0))}};
}

}  // namespace enamel::server
