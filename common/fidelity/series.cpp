#include "common/fidelity/series.h"

#include <algorithm>
#include <cmath>

namespace enamel::fidelity {

Series Difference(const Series& a, const Series& b) {
  Series out(std::min(a.size(), b.size()));
  for (size_t i = 0; i < out.size(); ++i) out[i] = a[i] - b[i];
  return out;
}

double RmsOf(const Series& v) { return RmsOf(v, 0, v.size()); }

double RmsOf(const Series& v, size_t from, size_t to) {
  double sum = 0;
  for (size_t i = from; i < to; ++i) sum += Dot(v[i], v[i]);
  return to > from ? std::sqrt(sum / static_cast<double>(to - from)) : 0;
}

double WithinOf(const Series& v, double share) {
  if (v.empty()) return 0;
  std::vector<double> lengths;
  for (const dvec3& one : v) lengths.push_back(glm::length(one));
  // The nearest rank.
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(v.size())));
  const auto at = lengths.begin() + static_cast<long>(std::max<size_t>(rank, 1) - 1);
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

Series MeansOf(const Series& v, size_t n) {
  Series out(v.size() / n, dvec3(0));
  for (size_t i = 0; i < out.size() * n; ++i) out[i / n] += v[i] / static_cast<double>(n);
  return out;
}

}  // namespace enamel::fidelity
