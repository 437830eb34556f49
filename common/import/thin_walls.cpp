#include "common/import/thin_walls.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/cutting/voxel_limit.h"
#include "common/mesh/units.h"

namespace enamel::import {
namespace {

// Where the search along the normal looks, as shares of the limit: a wall thinner than the first is not found.
constexpr double kLooks[] = {0.02, 0.1, 0.25, 0.5, 0.75, 1};
constexpr int kHalvings = 8;  // then the thickness is known to a thousandth of the limit

// Depth at which the solid ends behind `at`; nothing when it does not within the limit, or does not begin there.
std::optional<double> ThicknessAt(const dvec3& at, const dvec3& inward,
                                  const std::function<bool(const dvec3&)>& inside, double limit) {
  double in = 0, out = 0;
  for (double look : kLooks) {
    if (inside(at + inward * (look * limit))) {
      in = look * limit;
      continue;
    }
    if (in == 0) return std::nullopt;
    out = look * limit;
    break;
  }
  if (out == 0) return std::nullopt;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (in + out) / 2;
    (inside(at + inward * middle) ? in : out) = middle;
  }
  return (in + out) / 2;
}

}  // namespace

std::optional<ThinWalls> FindThinWalls(const mesh::TriangleTree& surface,
                                       const std::function<bool(const dvec3&)>& inside,
                                       double limit_mm) {
  std::vector<double> sums;  // of area, up to and with each triangle
  double area = 0;
  for (uint32_t i = 0; i < surface.size(); ++i) {
    const auto& t = surface.At(i);
    sums.push_back(area += glm::length(glm::cross(t.b - t.a, t.c - t.a)) / 2);
  }
  const auto places = static_cast<int>(std::max(4000.0, 2 * area));
  int thin = 0;
  ThinWalls found;
  found.least_mm = limit_mm;
  for (int k = 0; k < places; ++k) {
    const double upto = area * (k + 0.5) / places;
    const auto i =
        static_cast<uint32_t>(std::upper_bound(sums.begin(), sums.end(), upto) - sums.begin());
    if (i >= surface.size()) continue;
    const auto& t = surface.At(i);
    const dvec3 normal = glm::cross(t.b - t.a, t.c - t.a);
    if (!(glm::length(normal) > 0)) continue;
    // Roberts' sequence of two spreads evenly over a triangle of many places. Kept off its edges: a point on one
    // is neither inside nor outside.
    double u = std::fmod(0.7548776662466927 * (k + 1), 1),
           v = std::fmod(0.5698402909980532 * (k + 1), 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    u = 0.01 + 0.97 * u;
    v = 0.01 + 0.97 * v;
    const dvec3 at = t.a + (t.b - t.a) * u + (t.c - t.a) * v;
    const auto thickness = ThicknessAt(at, -glm::normalize(normal), inside, limit_mm);
    if (!thickness) continue;
    ++thin;
    if (*thickness < found.least_mm) found.least_mm = *thickness, found.at_mm = at;
  }
  found.percent = 100.0 * thin / places;
  found.area_mm2 = area * thin / places;
  if (found.percent < kMinThin_percent) return std::nullopt;
  return found;
}

std::string Words(const ThinWalls& walls, int32_t voxel_nm) {
  const double voxel_mm = voxel_nm * 1e-6;
  std::string text =
      "warning: walls thinner than two voxels (" +
      mesh::Fixed(cutting::kThinnestWall_voxels * voxel_mm, 2) + " mm) behind " +
      mesh::Fixed(walls.area_mm2, 1) + " mm2 of the surface (" + mesh::Fixed(walls.percent, 1) +
      " %), the thinnest " + mesh::Fixed(walls.least_mm, 3) + " mm at " +
      mesh::Fixed(walls.at_mm.x, 1) + ", " + mesh::Fixed(walls.at_mm.y, 1) + ", " +
      mesh::Fixed(walls.at_mm.z, 1) +
      " mm: they measure too little or are left out, and a score there tells nothing";
  const auto carries_um = static_cast<int>(walls.least_mm / cutting::kThinnestWall_voxels * 1e3);
  if (carries_um >= 10)
    text += "; voxels of " + std::to_string(carries_um) + " um would carry them";
  return text;
}

}  // namespace enamel::import
