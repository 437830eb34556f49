#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace enamel::scoring {

// Dynamic time warping inside a Sakoe-Chiba band: cells (i, j) with |i - j * n/m| <= band only, so
// work is n * (2 band + 1) and never n * m. Returns the mean cost per step of the best alignment and
// the path. Requires: n, m >= 1, band >= 1. Source: Sakoe and Chiba 1978.
struct Alignment {
  double mean_cost = 0;
  std::vector<std::pair<uint32_t, uint32_t>> path;
};
Alignment AlignBanded(size_t n, size_t m, size_t band, const std::function<double(size_t, size_t)>& cost);

}  // namespace enamel::scoring
