#include "common/scoring/planes.h"

#include <algorithm>
#include <cmath>

#include "common/scoring/deviation.h"

namespace enamel::scoring {

// Normal equations about the means, so that the two slopes are a 2 x 2 system.
Plane FitPlane(const std::vector<Height>& heights) {
  Plane p;
  double area = 0;
  for (const Height& h : heights) {
    area += h.area;
    p.s0 += h.area * h.s, p.t0 += h.area * h.t, p.d0 += h.area * h.d;
  }
  if (!(area > 0)) return p;
  p.s0 /= area, p.t0 /= area, p.d0 /= area;
  double ss = 0, tt = 0, st = 0, sd = 0, td = 0;
  for (const Height& h : heights) {
    const double s = h.s - p.s0, t = h.t - p.t0, d = h.d - p.d0;
    ss += h.area * s * s, tt += h.area * t * t, st += h.area * s * t;
    sd += h.area * s * d, td += h.area * t * d;
  }
  const double determinant = ss * tt - st * st;
  if (determinant > 1e-6 * ss * tt) {
    p.b = (sd * tt - td * st) / determinant;
    p.c = (td * ss - sd * st) / determinant;
  } else if (ss > 0) {
    p.b = sd / ss;
  }
  return p;
}

Plane FitPlaneToMost(std::vector<Height>& heights, double least_m) {
  if (heights.empty()) return {};
  std::vector<WeightedValue> all;
  for (const Height& h : heights) all.push_back({h.d, h.area});
  Plane plane;
  plane.d0 = WeightedQuantile(std::move(all), 0.5);
  for (int i = 0; i < 4; ++i) {
    std::vector<WeightedValue> rests;
    for (const Height& h : heights) rests.push_back({std::fabs(h.d - plane.At(h)), h.area});
    const double most = std::max(least_m, 4 * WeightedQuantile(std::move(rests), 0.5));
    if (std::erase_if(heights,
                      [&](const Height& h) { return std::fabs(h.d - plane.At(h)) > most; }) == 0 &&
        i > 0) {
      break;
    }
    plane = FitPlane(heights);
  }
  return plane;
}

double WavesAbout(const Plane& plane, const std::vector<Height>& heights, double least_m) {
  // Of a sine, the crest is 1.41 of the root mean square and 2 of the median.
  constexpr double kReach = 2.5;
  std::vector<WeightedValue> rests;
  for (const Height& h : heights) rests.push_back({std::fabs(h.d - plane.At(h)), h.area});
  const double most = std::max(least_m, kReach * WeightedQuantile(rests, 0.5));
  double squares = 0, area = 0;
  for (const WeightedValue& r : rests) {
    const double rest = std::min(r.value, most);
    squares += r.weight * rest * rest;
    area += r.weight;
  }
  return area > 0 ? std::sqrt(squares / area) : 0;
}

}  // namespace enamel::scoring
