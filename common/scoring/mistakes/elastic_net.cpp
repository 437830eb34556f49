#include "common/scoring/mistakes/elastic_net.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace enamel::scoring {
namespace {

constexpr double kStill = 1e-7;

// m x = y, m symmetric and positive definite, by Cholesky's factors. `m` and `y` are spent; `y` is x.
void Solve(std::vector<std::vector<double>>& m, std::vector<double>& y) {
  const size_t n = y.size();
  for (size_t j = 0; j < n; ++j) {
    for (size_t i = j; i < n; ++i) {
      double sum = m[i][j];
      for (size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      m[i][j] = i == j ? std::sqrt(sum) : sum / m[j][j];
    }
    for (size_t k = 0; k < j; ++k) y[j] -= m[j][k] * y[k];
    y[j] /= m[j][j];
  }
  for (size_t j = n; j-- > 0;) {
    for (size_t i = j + 1; i < n; ++i) y[j] -= m[i][j] * y[i];
    y[j] /= m[j][j];
  }
}

// Sweeps of coordinate descent say which motions are not 0 and their signs. With
// these fixed the sum is quadratic, and its least value solves a linear system, which sweeps would need thousands for
// (feature-sign search: Lee et al. 2007, Advances in Neural Information Processing Systems 19).
class Fit {
 public:
  Fit(const std::vector<const NetColumn*>& columns, const std::vector<double>& weights,
      const std::vector<double>& d, const std::vector<double>& lambdas)
      : columns_(columns),
        weights_(weights),
        d_(d),
        lambdas_(lambdas),
        rest_(d),
        beta_(columns.size()) {}

  std::vector<double> Run() {
    std::vector<size_t> all(columns_.size());
    std::iota(all.begin(), all.end(), size_t{0});
    for (int i = 0; i < kMaxRounds && Sweep(all) >= kStill; ++i) {
      const std::vector<size_t> active = Active();
      for (int j = 0; j < kFewSweeps && Sweep(active) >= kStill; ++j) {
      }
      SolveFor(Active());
    }
    return std::move(beta_);
  }

 private:
  std::vector<size_t> Active() const {
    std::vector<size_t> out;
    for (size_t k = 0; k < beta_.size(); ++k) {
      if (beta_[k] != 0) out.push_back(k);
    }
    return out;
  }
  // Sum of w phi v.
  double Product(const NetColumn& column, const std::vector<double>& v) const {
    double sum = 0;
    for (const auto& [i, phi] : column) sum += weights_[i] * phi * v[i];
    return sum;
  }
  // Each to its own least value, in turn. The largest step.
  double Sweep(const std::vector<size_t>& which) {
    double most = 0;
    for (const size_t k : which) {
      const double wanted = Product(*columns_[k], rest_) + beta_[k];
      const double kept = std::max(0.0, std::fabs(wanted) - lambdas_[k]) / (1 + kRidge);
      const double step = (wanted < 0 ? -kept : kept) - beta_[k];
      if (step == 0) continue;
      for (const auto& [i, phi] : *columns_[k]) rest_[i] -= step * phi;
      beta_[k] += step;
      most = std::max(most, std::fabs(step));
    }
    return most;
  }

  std::vector<std::vector<double>> ProductsOf(const std::vector<size_t>& which) const {
    std::vector<std::vector<double>> out(which.size(), std::vector<double>(which.size()));
    for (size_t a = 0; a < which.size(); ++a) {
      std::vector<double> spread(d_.size());
      for (const auto& [i, phi] : *columns_[which[a]]) spread[i] = phi;
      for (size_t b = 0; b <= a; ++b) out[a][b] = out[b][a] = Product(*columns_[which[b]], spread);
    }
    return out;
  }

  // All of `active` to the least value that they have together, or as far as the first of them is 0 on the way; then the
  // others from there. The sum only falls.
  void SolveFor(std::vector<size_t> active) {
    const std::vector<std::vector<double>> products = ProductsOf(active);
    std::vector<size_t> left(active.size());
    std::iota(left.begin(), left.end(), size_t{0});
    for (int i = 0; i < kMaxSolved && !left.empty(); ++i) {
      const std::vector<double> wanted = LeastOf(active, products, left);
      double way = 1;
      for (size_t a = 0; a < left.size(); ++a) way = std::min(way, Way(active[left[a]], wanted[a]));
      std::vector<size_t> still;
      for (size_t a = 0; a < left.size(); ++a) {
        double& beta = beta_[active[left[a]]];
        const bool ends = way < 1 && Way(active[left[a]], wanted[a]) == way;
        beta = ends ? 0 : way < 1 ? beta + way * (wanted[a] - beta) : wanted[a];
        if (!ends) still.push_back(left[a]);
      }
      if (still.size() == left.size()) break;
      left = std::move(still);
    }
    rest_ = d_;
    for (const size_t k : active) {
      for (const auto& [i, phi] : *columns_[k]) rest_[i] -= beta_[k] * phi;
    }
  }
  // The share of the way from beta to `wanted` at which it is 0; 1 where that is not on the way.
  double Way(size_t k, double wanted) const {
    const double beta = beta_[k];
    return (beta > 0) != (wanted > 0) ? std::min(1.0, beta / (beta - wanted)) : 1;
  }
  std::vector<double> LeastOf(const std::vector<size_t>& active,
                              const std::vector<std::vector<double>>& products,
                              const std::vector<size_t>& left) const {
    std::vector<std::vector<double>> m(left.size(), std::vector<double>(left.size()));
    std::vector<double> y(left.size());
    for (size_t a = 0; a < left.size(); ++a) {
      const size_t k = active[left[a]];
      for (size_t b = 0; b <= a; ++b) m[a][b] = products[left[a]][left[b]];
      m[a][a] += kRidge;
      y[a] = Product(*columns_[k], d_) - (beta_[k] < 0 ? -lambdas_[k] : lambdas_[k]);
    }
    Solve(m, y);
    return y;
  }

  static constexpr int kMaxRounds = 400, kFewSweeps = 20, kMaxSolved = 20;
  const std::vector<const NetColumn*>& columns_;
  const std::vector<double>&weights_, &d_, &lambdas_;
  std::vector<double> rest_, beta_;
};

}  // namespace

std::vector<double> ElasticNet(const std::vector<const NetColumn*>& columns,
                               const std::vector<double>& weights, const std::vector<double>& d,
                               const std::vector<double>& lambdas) {
  return Fit(columns, weights, d, lambdas).Run();
}

}  // namespace enamel::scoring
