#include "station/mouth/neck.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::station::mouth {
namespace {

using cutting::Tissue;

constexpr double kTurn = 2 * std::numbers::pi;
// Steps of the search. A cement line rises by 3.5 mm over 4 mm at most: a step along it is below a
// twentieth of a tooth's width.
constexpr double kDown_mm = 0.15, kOut_mm = 0.2, kWidest_mm = 8;
// Just below the surface, where it is enamel even at its thin edge.
constexpr double kBelow_mm = 0.08;

dvec3 OnRay(const glm::dvec2& middle, double angle, double radius, double z) {
  return {middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle), z};
}

// The lowest enamel on the surface of this side.
std::optional<double> CementLine_mm(const TissueAt& tissue, const glm::dvec2& middle, double angle,
                                    double lowest, double highest) {
  for (double z = lowest; z <= highest; z += kDown_mm) {
    const double r = RadiusAt_mm(tissue, middle, angle, z);
    if (r > kBelow_mm && tissue(OnRay(middle, angle, r - kBelow_mm, z)) == Tissue::kEnamel)
      return z;
  }
  return std::nullopt;
}

}  // namespace

double Around::Angle(size_t i) { return kTurn * static_cast<double>(i) / kCount; }

size_t Around::Nearest(double angle_rad) {
  const double turns = angle_rad / kTurn;
  return static_cast<size_t>(std::lround((turns - std::floor(turns)) * kCount)) % kCount;
}

double Around::At(double angle_rad) const {
  const double turns = angle_rad / kTurn, place = (turns - std::floor(turns)) * kCount;
  const auto i = static_cast<size_t>(place) % kCount;
  const double t = place - std::floor(place);
  const double p0 = values_[(i + kCount - 1) % kCount], p1 = values_[i],
               p2 = values_[(i + 1) % kCount], p3 = values_[(i + 2) % kCount];
  return p1 +
         0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

Around Around::Smoothed(double deviation_rad) const {
  const double samples = deviation_rad * kCount / kTurn;
  const int reach =
      std::min(static_cast<int>(std::ceil(3 * samples)), static_cast<int>(kCount) / 2);
  Around out;
  for (size_t i = 0; i < kCount; ++i) {
    double sum = 0, weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double weight = std::exp(-0.5 * k * k / (samples * samples));
      sum += weight *
             values_[(i + kCount + static_cast<size_t>(k + reach) - static_cast<size_t>(reach)) %
                     kCount];
      weights += weight;
    }
    out[i] = sum / weights;
  }
  return out;
}

double Around::Mean() const {
  double sum = 0;
  for (double v : values_) sum += v;
  return sum / kCount;
}

double RadiusAt_mm(const TissueAt& tissue, const glm::dvec2& middle, double angle, double z) {
  auto solid = [&](double r) { return tissue(OnRay(middle, angle, r, z)) != Tissue::kAir; };
  double in = 0;
  if (!solid(0)) return 0;
  while (in < kWidest_mm && solid(in + kOut_mm)) in += kOut_mm;
  double out = in + kOut_mm;
  for (int i = 0; i < 6; ++i) {
    const double middle_r = 0.5 * (in + out);
    (solid(middle_r) ? in : out) = middle_r;
  }
  return in;
}

std::optional<Neck> NeckOf(const TissueAt& tissue, const glm::dvec2& middle_mm, double lowest_mm,
                           double highest_mm) {
  std::array<std::optional<double>, Around::kCount> found;
  size_t count = 0;
  for (size_t i = 0; i < Around::kCount; ++i) {
    found[i] = CementLine_mm(tissue, middle_mm, Around::Angle(i), lowest_mm, highest_mm);
    // Enamel at the lowest height is no line: the crown ends below, or there is none.
    if (found[i] && *found[i] <= lowest_mm) found[i].reset();
    count += found[i].has_value();
  }
  if (4 * count < 3 * Around::kCount) return std::nullopt;
  Around margin;
  for (size_t i = 0; i < Around::kCount; ++i) {
    size_t k = 0;
    while (!found[(i + k) % Around::kCount]) ++k;
    margin[i] = *found[(i + k) % Around::kCount] + kAboveCementLine_mm;
  }
  // Over the staircase of voxels and steps, which is finer than 4 degrees of a molar's neck.
  return WithMargin(tissue, middle_mm, margin.Smoothed(0.15));
}

Neck WithMargin(const TissueAt& tissue, const glm::dvec2& middle_mm, const Around& margin_mm) {
  constexpr double kScallop_rad = 0.5;
  Neck out{middle_mm, margin_mm, {}, {}, margin_mm.Smoothed(kScallop_rad)};
  for (size_t i = 0; i < Around::kCount; ++i) {
    out.radius_mm[i] = RadiusAt_mm(tissue, middle_mm, Around::Angle(i), margin_mm[i]);
  }
  out.girth_mm = out.radius_mm.Smoothed(kScallop_rad);
  return out;
}

double FromTooth_mm(const Neck& neck, double x, double y) {
  const double dx = x - neck.middle_mm.x, dy = y - neck.middle_mm.y, angle = std::atan2(dy, dx),
               away = std::hypot(dx, dy), out = away - neck.radius_mm.At(angle);
  const double share = std::clamp(out / kScallops_mm, 0.0, 1.0);
  return glm::mix(out, away - neck.girth_mm.At(angle), share * share * (3 - 2 * share));
}

}  // namespace enamel::station::mouth
