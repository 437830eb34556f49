#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "server/agreement/agreement.h"

// Intervals by drawing the work again (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap
// (1993), chapter 13, the percentile interval). For this folder. Deterministic: the same marks give
// the same interval everywhere.
namespace enamel::server {

inline constexpr int kBootstrapDraws = 2000;

// The interval of 95 % of a figure of `works` pieces of work. `figure`: of the pieces with these
// indices, drawn with replacement; none where a draw gives none, which is then left out. None where
// fewer than half of the draws give one.
std::optional<Interval> BootstrapInterval(
    size_t works,
    const std::function<std::optional<double>(const std::vector<size_t>& drawn)>& figure);

}  // namespace enamel::server
