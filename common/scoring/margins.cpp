#include "common/scoring/margins.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/math/trig.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr int kPlaces = 21;
constexpr double kMiddle = 0.5;     // of a wall's length
constexpr double kMaxGap_m = 1e-3;  // of a round of 2.4 mm between upright faces
constexpr double kUnder_voxels = 3, kUnder_m = 0.1e-3;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Outwards from the solid; none where the volume says nothing.
std::optional<dvec3> Outward(const Volume& volume, const dvec3& at_m) {
  const cutting::GridSpec& grid = volume.spec();
  const dvec3 slope = volume.SlopeAtSample((at_m - grid.origin_m()) / grid.voxel_m());
  const double length = std::sqrt(Dot(slope, slope));
  if (!(length > 0.5)) return std::nullopt;  // of a distance it is 1
  return slope / length;
}

struct MarginPoint {
  dvec3 at_m{0};
  double angle_deg = 0;
};

// Outline points that have an angle.
std::vector<MarginPoint> MarginOf(const Volume& initial, const CutSide& side) {
  const double under = std::max(kUnder_voxels * initial.spec().voxel_m(), kUnder_m);
  std::vector<MarginPoint> out;
  for (const dvec3& p : OutlineOf(side)) {
    const std::optional<dvec3> tooth = Outward(initial, p);
    if (!tooth) continue;
    dvec3 q = p - *tooth * under;
    std::optional<dvec3> wall = Outward(*side.volume, q);
    if (!wall) continue;
    // Onto the wall, where its direction is its own and not that of an edge near by.
    q -= *wall * side.volume->DistanceAt_m(q);
    wall = Outward(*side.volume, q);
    if (!wall) continue;
    const double dot = Dot(*tooth, *wall);
    const dvec3 cross = glm::cross(*tooth, *wall);
    const double sine = std::sqrt(Dot(cross, cross));
    if (!(sine > 0.1)) continue;  // the surface itself: nothing was cut under it
    out.push_back({p, 90 + kDegrees * ArcTan(dot / sine)});
  }
  return out;
}

}  // namespace

LineAngleFigures MeasureLineAngles(const CutSide& attempt, const Walls& walls,
                                   const OpenBox& target) {
  LineAngleFigures out;
  const WallFigures& floor = walls[kFloor];
  std::vector<double> radii;
  int looked = 0;
  bool made = floor.made;
  for (size_t w = 0; w < kFloor; ++w) {
    const WallFigures& wall = walls[w];
    if (!wall.in_task || !floor.in_task) continue;
    out.in_task = true;
    made = made && wall.made;
    if (!wall.made || !floor.made) continue;
    const bool along_y = w == kMesial || w == kDistal;
    const dvec3 axis = along_y ? dvec3(0, 1, 0) : dvec3(1, 0, 0);
    const dvec3 &a = wall.facet.normal, &b = floor.facet.normal;
    const double volume = Dot(a, glm::cross(b, axis));
    const double half_sine = std::sqrt(0.5 * (1 + Dot(a, b)));
    if (!(std::fabs(volume) > 0.1) || !(half_sine < 0.99)) continue;  // hardly an edge
    const dvec3 bisector = (a + b) / std::sqrt(Dot(a + b, a + b));
    const double lo = along_y ? target.lo_m.y : target.lo_m.x;
    const double hi = along_y ? target.hi_m.y : target.hi_m.x;
    for (int i = 0; i < kPlaces; ++i) {
      const double share = 0.5 + kMiddle * (static_cast<double>(i) / (kPlaces - 1) - 0.5);
      const double at = lo + share * (hi - lo);
      // The point of both planes that lies so far along.
      const dvec3 corner = (glm::cross(b, axis) * wall.facet.reach_m +
                            glm::cross(axis, a) * floor.facet.reach_m + glm::cross(a, b) * at) /
                           volume;
      ++looked;
      const double gap = SurfaceAlong_m(*attempt.volume, corner, bisector, kMaxGap_m);
      if (!(std::fabs(gap) < kMaxGap_m)) continue;
      radii.push_back(std::max(0.0, gap) / (1 / half_sine - 1));
    }
  }
  out.made = made && !radii.empty() && 2 * static_cast<int>(radii.size()) >= looked;
  if (out.made) out.radius_m = Median(std::move(radii));
  return out;
}

MarginFigures MeasureMargin(const Volume& initial, const CutSide& attempt,
                            const CutSide& reference) {
  MarginFigures out;
  const std::vector<MarginPoint> wanted = MarginOf(initial, reference);
  out.in_task = !wanted.empty();
  if (!out.in_task) return out;
  const std::vector<MarginPoint> made = MarginOf(initial, attempt);
  out.made = !made.empty();
  if (!out.made) return out;
  std::vector<double> angles;
  std::vector<WeightedValue> differences;
  for (const MarginPoint& p : wanted) {
    const MarginPoint* nearest = nullptr;
    double best = std::numeric_limits<double>::infinity();
    for (const MarginPoint& q : made) {
      const double d = Dot(p.at_m - q.at_m, p.at_m - q.at_m);
      if (d < best) best = d, nearest = &q;
    }
    angles.push_back(nearest->angle_deg);
    differences.push_back({std::fabs(nearest->angle_deg - p.angle_deg), 1});
  }
  out.angle_deg = Median(std::move(angles));
  out.worst_deg = WeightedQuantile(std::move(differences), 0.95);
  return out;
}

}  // namespace enamel::scoring
