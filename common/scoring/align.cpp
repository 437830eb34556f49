#include "common/scoring/align.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace enamel::scoring {
namespace {

constexpr double kUnreachable = std::numeric_limits<double>::infinity();

enum Step : uint8_t { kDiagonal, kAlongI, kAlongJ };

// The rows of each column that are in the band.
struct Band {
  size_t n, m, half_width;

  // In whole numbers, i m against j n: no rounding decides which cells there are.
  size_t First(size_t j) const {
    size_t centre = j * n;
    size_t below = half_width * m;
    return centre <= below ? 0 : std::min((centre - below + m - 1) / m, n - 1);
  }
  size_t Last(size_t j) const { return std::min((j * n + half_width * m) / m, n - 1); }
};

}  // namespace

Alignment AlignBanded(size_t n, size_t m, size_t band,
                      const std::function<double(size_t, size_t)>& cost, Pairing pairing) {
  ENAMEL_CHECK(n >= 1 && m >= 1 && band >= 1);
  Band rows{n, m, std::max(band, n / m + 1)};
  size_t width = 2 * rows.half_width + 1;
  // A byte a cell and only two columns of costs: ten minutes take 1.8 MB. The path needs the steps
  // alone.
  std::vector<uint8_t> step(m * width, kDiagonal);
  std::vector<double> before, now;
  size_t before_first = 0;
  for (size_t j = 0; j < m; ++j) {
    size_t first = rows.First(j), last = rows.Last(j);
    now.assign(last - first + 1, kUnreachable);
    auto previous = [&](size_t i) {
      return i >= before_first && i - before_first < before.size() ? before[i - before_first]
                                                                   : kUnreachable;
    };
    for (size_t i = first; i <= last; ++i) {
      double best = i == 0 && j == 0 ? 0.0 : i > 0 ? previous(i - 1) : kUnreachable;
      uint8_t how = kDiagonal;
      // Strictly less, so that of equal costs the diagonal stays and the path is the same
      // everywhere.
      if (double up = i > first ? now[i - first - 1] : kUnreachable; up < best) {
        best = up;
        how = kAlongI;
      }
      if (double left = previous(i); left < best) {
        best = left;
        how = kAlongJ;
      }
      if (best == kUnreachable) continue;
      const double here = cost(i, j);
      now[i - first] = pairing == Pairing::kSum ? best + here : std::max(best, here);
      step[j * width + (i - first)] = how;
    }
    before.swap(now);
    before_first = first;
  }

  Alignment out;
  const double least = before[n - 1 - before_first];
  ENAMEL_CHECK(least < kUnreachable);
  size_t i = n - 1, j = m - 1;
  for (;;) {
    out.path.emplace_back(static_cast<uint32_t>(i), static_cast<uint32_t>(j));
    if (i == 0 && j == 0) break;
    switch (step[j * width + (i - rows.First(j))]) {
      case kDiagonal:
        --i;
        --j;
        break;
      case kAlongI:
        --i;
        break;
      default:
        --j;
        break;
    }
  }
  std::reverse(out.path.begin(), out.path.end());
  double sum = 0;
  for (const auto& [a, b] : out.path) {
    const double here = cost(a, b);
    sum += here;
    out.worst_cost = std::max(out.worst_cost, here);
  }
  // The columns' own sum, which was added in the path's order too.
  out.mean_cost = (pairing == Pairing::kSum ? least : sum) / static_cast<double>(out.path.size());
  return out;
}

}  // namespace enamel::scoring
