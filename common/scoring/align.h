#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace enamel::scoring {

// The cost of a pairing: the sum of its pairs (dynamic time warping), or the worst of them (the
// discrete Frechet distance; Eiter and Mannila, TU Wien, report CD-TR 94/64, 1994).
enum class Pairing { kSum, kWorst };

// The cheapest monotone pairing of two series, and its path for a side-by-side view.
struct Alignment {
  double mean_cost = 0;                             // of the path's pairs
  double worst_cost = 0;                            // likewise
  std::vector<std::pair<uint32_t, uint32_t>> path;  // (i, j), from (0, 0) to (n - 1, m - 1)
};

// Dynamic time warping inside a Sakoe-Chiba band: cells (i, j) with |i - j n/m| <= band only, so
// work and memory are m (2 band + 1) and never n m. Steps are (1,0), (0,1), (1,1), each with weight
// 1; of equally cheap ones the diagonal is taken. A band narrower than one step of the slope
// (n/m + 1) would cut the path and is widened to it.
// Requires: n, m, band >= 1; cost(i, j) finite and >= 0. Thread safety: a function, any thread.
// Deterministic. Source: Sakoe and Chiba, IEEE Trans. ASSP 26(1), 1978.
Alignment AlignBanded(size_t n, size_t m, size_t band,
                      const std::function<double(size_t, size_t)>& cost,
                      Pairing pairing = Pairing::kSum);

}  // namespace enamel::scoring
