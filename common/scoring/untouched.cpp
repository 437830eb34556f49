#include "common/scoring/untouched.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

constexpr double kMinSide = 0.1;  // of the task: a smaller one is an edge of the next

// The highest solid point of a column, neighbours apart; the grid's bottom where there is none.
double HighestAt(const Volume& volume, double x_m, double y_m) {
  const double h = volume.spec().voxel_m(), bottom = volume.spec().origin_m().z;
  double above = h;
  for (double z = bottom + static_cast<double>(volume.spec().voxels().z - 1) * h; z > bottom;
       z -= h) {
    const double d = volume.DistanceAt_m({x_m, y_m, z});
    if (d < 0 && volume.TissueAtPoint({x_m, y_m, z}) != Tissue::kNeighbour) {
      return z + h * d / (d - above);
    }
    above = d;
  }
  return bottom;
}

}  // namespace

StumpFigures MeasureStump(const Volume& initial, const Volume& attempt, const Volume& reference,
                          const OpenBox& target, double bottom_z_m) {
  const double h = initial.spec().voxel_m();
  struct Column {
    double x_m, y_m, asked_z_m;
  };
  std::vector<Column> columns;
  double highest = bottom_z_m;
  for (double y = target.lo_m.y; y <= target.hi_m.y; y += h) {
    for (double x = target.lo_m.x; x <= target.hi_m.x; x += h) {
      columns.push_back({x, y, HighestAt(reference, x, y)});
      highest = std::max(highest, columns.back().asked_z_m);
    }
  }
  double over_top = 0, asked = 0, taken = 0, stump = 0, stands = 0;
  for (const Column& c : columns) {
    if (c.asked_z_m < 0.5 * (bottom_z_m + highest)) continue;
    const double was = HighestAt(initial, c.x_m, c.y_m);
    ++over_top;
    asked += was - c.asked_z_m;
    const double now = HighestAt(attempt, c.x_m, c.y_m);
    taken += was - now;
    stump += c.asked_z_m - bottom_z_m;
    stands += std::clamp(now, bottom_z_m, c.asked_z_m) - bottom_z_m;
  }
  return {asked > 0 ? taken / asked : 1, over_top > 0 ? asked / over_top : 0,
          stump > 0 ? stands / stump : 1};
}

std::array<double, 4> SidesDone(const Volume& initial, const Volume& attempt,
                                const Volume& reference, const OpenBox& target) {
  const cutting::GridSpec& spec = initial.spec();
  const dvec3 middle = 0.5 * (target.lo_m + target.hi_m), half = target.hi_m - middle;
  const ChangedBricks changed(initial, reference);
  std::array<int64_t, 4> task{}, done{};
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!changed.Brick(b)) continue;
    const BrickSamples before(initial, b), after(attempt, b), wanted(reference, b);
    const ivec3& n = spec.bricks;
    const ivec3 first = ivec3(b % n.x, b / n.x % n.y, b / (n.x * n.y)) * kBrickSide;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int32_t f0 = before.Solid(i), fr = std::min(f0, wanted.Solid(i));
      if (f0 == fr) continue;
      const dvec3 p =
          spec.origin_m() + dvec3(first + ivec3(i & 7, i >> 3 & 7, i >> 6)) * spec.voxel_m();
      const double x = (p.x - middle.x) * half.y, y = (p.y - middle.y) * half.x;
      const size_t side = std::fabs(x) >= std::fabs(y) ? (x < 0) : 2 + (y < 0);
      task[side] += f0 - fr;
      done[side] += f0 - std::max(fr, std::min(f0, after.Solid(i)));
    }
  }
  const auto all = static_cast<double>(std::accumulate(task.begin(), task.end(), int64_t{0}));
  std::array<double, 4> out;
  for (size_t s = 0; s < out.size(); ++s) {
    const auto of = static_cast<double>(task[s]);
    out[s] = of > 0 && of >= kMinSide * all ? static_cast<double>(done[s]) / of : 1;
  }
  return out;
}

}  // namespace enamel::scoring
