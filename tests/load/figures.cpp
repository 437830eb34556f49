#include "tests/load/figures.h"

#include <algorithm>
#include <cmath>

namespace enamel::load {

double Quantile(std::vector<float>& values, double p) {
  if (values.empty()) return 0;
  auto rank = static_cast<size_t>(std::ceil(p * static_cast<double>(values.size())));
  auto at = values.begin() + static_cast<long>(std::clamp<size_t>(rank, 1, values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

void StreamFigures::Add(StreamFigures&& other) {
  ticks_sent += other.ticks_sent;
  ticks_committed += other.ticks_committed;
  ticks_taken_back += other.ticks_taken_back;
  bytes_sent += other.bytes_sent;
  chunk_bytes += other.chunk_bytes;
  reconnects += other.reconnects;
  refused += other.refused;
  repeats += other.repeats;
  disorders += other.disorders;
  cuts += other.cuts;
  live_states += other.live_states;
  commit_ms.insert(commit_ms.end(), other.commit_ms.begin(), other.commit_ms.end());
  late_ms.insert(late_ms.end(), other.late_ms.begin(), other.late_ms.end());
}

}  // namespace enamel::load
