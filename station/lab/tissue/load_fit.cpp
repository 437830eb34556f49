#include "station/lab/tissue/load_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "station/lab/tissue/statistics.h"

namespace enamel::station::lab {
namespace {

using cutting::FeedExponent;

constexpr size_t kStretches = 20;
// Speeds that differ by less tell a root from a line nowhere: over a factor of 1.5 the two differ by 1 %.
constexpr double kMinSpread = 2;

struct Line {
  double offset = 0, slope = 0, error = 0;  // mean squared
};

// Least squares of F on v^m with an offset of at least 0, over all points but those of stretch `without`.
Line Fitted(const std::vector<CutPoint>& points, double power, size_t without) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (i * kStretches / points.size() == without) continue;
    const double at = std::pow(points[i].speed_mm_s, power), f = points[i].force_n;
    n += 1, x += at, y += f, xx += at * at, xy += at * f, yy += f * f;
  }
  Line line;
  const double spread = xx - x * x / n;
  line.slope = spread > 0 ? (xy - x * y / n) / spread : 0;
  line.offset = (y - line.slope * x) / n;
  if (line.offset < 0) {
    line.offset = 0;
    line.slope = xx > 0 ? xy / xx : 0;
  }
  line.error = (yy - 2 * line.offset * y - 2 * line.slope * xy + n * line.offset * line.offset +
                2 * line.offset * line.slope * x + line.slope * line.slope * xx) /
               n;
  return line;
}

// A figure of all points and of those without each stretch.
template <class Of>
Estimate Jackknifed(Of of) {
  constexpr auto n = static_cast<double>(kStretches);
  std::array<double, kStretches> without{};
  double mean = 0, sum = 0;
  for (size_t k = 0; k < kStretches; ++k) mean += (without[k] = of(k)) / n;
  for (double value : without) sum += (value - mean) * (value - mean);
  const double value = of(kStretches), half = cut::Student975(n - 1) * std::sqrt(sum * (n - 1) / n);
  return {value, value - half, value + half};
}

void FitFriction(const std::vector<CutPoint>& points, LoadFit& fit) {
  fit.friction = Jackknifed([&](size_t without) {
    double along = 0, across = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      if (i * kStretches / points.size() == without || !points[i].across_n) continue;
      along += points[i].force_n;
      across += *points[i].across_n;
    }
    return along > 0 ? std::fabs(across) / along : 0;
  });
  const auto crossed = std::count_if(points.begin(), points.end(),
                                     [](const CutPoint& p) { return p.across_n.has_value(); });
  if (2 * static_cast<size_t>(crossed) < points.size()) {
    fit.why_no_friction =
        "needs three columns of position and of force, the bur's axis, and motion across it";
  } else if (fit.friction.low <= 0) {
    fit.why_no_friction = "the force across the motion is in its noise";
  }
  fit.friction_told = fit.why_no_friction.empty();
}

}  // namespace

LoadFit FitLoad(const std::vector<CutPoint>& points) {
  LoadFit fit;
  std::vector<double> speeds;
  for (const CutPoint& p : points) speeds.push_back(p.speed_mm_s);
  fit.feed_mm_s = cut::Quantile(speeds, 0.5);
  auto error = [&](double power) {
    return [&points, power](size_t without) { return Fitted(points, power, without).error; };
  };
  const Estimate gain =
      Jackknifed([&](size_t k) { return error(1)(k) - error(0.5)(k); });  // above 0: the root's
  const bool root = gain.value > 0;
  fit.exponent = root ? FeedExponent::kHalf : FeedExponent::kOne;
  if (cut::Quantile(speeds, 0.9) < kMinSpread * cut::Quantile(speeds, 0.1)) {
    fit.why_no_exponent = "the speeds differ by less than a factor of two: record at five loads";
  } else if (gain.low <= 0 && gain.high >= 0) {
    fit.why_no_exponent = "both exponents fit within the noise: record at more loads, for longer";
  }
  fit.exponent_told = fit.why_no_exponent.empty();
  if (!fit.exponent_told) fit.exponent = FeedExponent::kOne;
  const double power = fit.exponent == FeedExponent::kHalf ? 0.5 : 1;
  fit.coulomb_n = Jackknifed([&](size_t k) { return Fitted(points, power, k).offset; });
  fit.coulomb_n.low = std::max(0.0, fit.coulomb_n.low);
  fit.at_feed_n = Jackknifed(
      [&](size_t k) { return Fitted(points, power, k).slope * std::pow(fit.feed_mm_s, power); });
  fit.residual_n = std::sqrt(std::max(0.0, error(power)(kStretches)));
  fit.other_n = std::sqrt(std::max(0.0, error(1.5 - power)(kStretches)));
  FitFriction(points, fit);
  return fit;
}

}  // namespace enamel::station::lab
