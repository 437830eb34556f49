#include "common/scoring/movement/path_align.h"

#include <algorithm>
#include <cmath>

namespace enamel::scoring {
namespace {

constexpr double kAlignRate_hz = 25;
constexpr double kMinStep_m = 20e-6;
constexpr size_t kBandShare = 10;

// Means of `stride` samples: the position of the first, the mean force.
std::vector<PathSample> Resample(const std::vector<PathSample>& samples, size_t stride) {
  std::vector<PathSample> out;
  for (size_t i = 0; i < samples.size(); i += stride) {
    size_t end = std::min(i + stride, samples.size());
    PathSample s = samples[i];
    for (size_t k = i + 1; k < end; ++k) s.force_n += samples[k].force_n;
    s.force_n /= static_cast<double>(end - i);
    out.push_back(s);
  }
  return out;
}

PathPair ByTime(const std::vector<PathSample>& attempt, const std::vector<PathSample>& reference) {
  size_t longest = std::max(attempt.size(), reference.size());
  double step_s =
      longest > 1 && attempt.size() > 1 ? attempt[1].time_s - attempt[0].time_s : 1 / kAlignRate_hz;
  size_t stride = 1;
  while (longest > stride * PathPair::kMaxSamples ||
         // 0.999: two steps of 0.02 s are 25 Hz even if their sum is a hair short.
         static_cast<double>(stride) * step_s * kAlignRate_hz < 0.999) {
    ++stride;
  }
  return {Resample(attempt, stride), Resample(reference, stride)};
}

// At 0, step, 2 step, ... of the way. A jump after a gap has no way and is left out.
std::vector<PathSample> EveryWay(const std::vector<PathSample>& samples, double step_m) {
  std::vector<PathSample> out;
  size_t next = 1;
  for (size_t k = 0; k < PathPair::kMaxSamples; ++k) {
    const double way = static_cast<double>(k) * step_m;
    if (way > samples.back().way_m) break;
    while (next < samples.size() && samples[next].way_m <= way) ++next;
    const PathSample& a = samples[next - 1];
    PathSample s = a;
    s.way_m = way;
    if (next < samples.size()) {
      const PathSample& b = samples[next];
      const double share = (way - a.way_m) / (b.way_m - a.way_m);
      s.time_s += (b.time_s - a.time_s) * share;
      s.anchor_m += (b.anchor_m - a.anchor_m) * share;
      s.force_n += (b.force_n - a.force_n) * share;
    }
    out.push_back(s);
  }
  return out;
}

PathPair ByWay(const std::vector<PathSample>& attempt, const std::vector<PathSample>& reference) {
  const double longest = std::max(attempt.back().way_m, reference.back().way_m);
  const double step =
      std::max(kMinStep_m, longest / static_cast<double>(PathPair::kMaxSamples - 1));
  return {EveryWay(attempt, step), EveryWay(reference, step)};
}

double Distance(const dvec3& a, const dvec3& b) { return std::sqrt(Dot(a - b, a - b)); }

template <typename Cost>
Alignment Align(const PathPair& paths, Pairing pairing, const Cost& cost) {
  const auto &a = paths.attempt, &b = paths.reference;
  const size_t band = std::max<size_t>(1, std::max(a.size(), b.size()) / kBandShare);
  return AlignBanded(
      a.size(), b.size(), band, [&](size_t i, size_t j) { return cost(a[i], b[j]); }, pairing);
}

}  // namespace

PathPair ResampleAlike(const ProcessRecorder& attempt, const ProcessRecorder& reference,
                       PathBy by) {
  return by == PathBy::kTime ? ByTime(attempt.samples(), reference.samples())
                             : ByWay(attempt.samples(), reference.samples());
}

Alignment AlignPoses(const PathPair& paths, Pairing pairing) {
  return Align(paths, pairing, [](const PathSample& a, const PathSample& b) {
    return Distance(a.anchor_m, b.anchor_m);
  });
}

Alignment AlignForces(const PathPair& paths) {
  return Align(paths, Pairing::kSum, [](const PathSample& a, const PathSample& b) {
    return Distance(a.force_n, b.force_n);
  });
}

}  // namespace enamel::scoring
