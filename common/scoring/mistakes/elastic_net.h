#pragma once

#include <cstdint>
#include <utility>
#include <vector>

// The elastic net (Zou and Hastie 2005, J. R. Stat. Soc. B 67:301): the sizes beta at which
//
//     1/2 sum_i w_i (d_i - sum_k beta_k phi_k(i))^2 + sum_k lambda_k |beta_k| + eps/2 |beta|^2
//
// is least, with eps = kRidge. Strictly convex: one answer, which moves continuously with d. The columns phi have unit
// norm, sum_i w_i phi_k(i)^2 = 1. Deterministic: + - * / sqrt in a fixed order. Thread safety: functions, any thread.
namespace enamel::scoring {

inline constexpr double kRidge = 1e-4;

// Rows where phi is not 0, in their order, and its value there.
using NetColumn = std::vector<std::pair<uint32_t, double>>;

// Requires: `weights` and `d` of one size, `columns` and `lambdas` of one size, rows below the former.
std::vector<double> ElasticNet(const std::vector<const NetColumn*>& columns,
                               const std::vector<double>& weights, const std::vector<double>& d,
                               const std::vector<double>& lambdas);

}  // namespace enamel::scoring
