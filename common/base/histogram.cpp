#include "common/base/histogram.h"

#include <algorithm>

namespace enamel {

void Histogram::Add(std::chrono::nanoseconds duration) {
  double s = std::chrono::duration<double>(duration).count();
  auto step = std::lower_bound(kUpToS.begin(), kUpToS.end(), s) - kUpToS.begin();
  // A reader may see the count without the sum. Prometheus takes rates over minutes; the next
  // answer has both.
  counts_[static_cast<size_t>(step)].fetch_add(1, std::memory_order_relaxed);
  sum_ns_.fetch_add(static_cast<uint64_t>(std::max<int64_t>(duration.count(), 0)),
                    std::memory_order_relaxed);
}

Histogram::Counts Histogram::counts() const {
  Counts out;
  for (size_t i = 0; i < counts_.size(); ++i) out.each[i] = counts_[i].load();
  out.sum_s = 1e-9 * static_cast<double>(sum_ns_.load());
  return out;
}

}  // namespace enamel
