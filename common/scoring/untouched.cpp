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

constexpr double kLeastSide = 0.1;  // of the task: a smaller one is an edge of the next
constexpr double kLeastContact_m2 = 0.1e-6;
constexpr double kReach_m = 3e-3;  // from the box's side to the neighbour
// What stands farther inside is a pillar in the box, not the contact: chosen, a bur's radius.
constexpr double kShell_m = 0.5e-3;

// One line from the box's middle outwards along x.
class ContactLine {
 public:
  ContactLine(const Volume& initial, const Volume& attempt, const Volume& reference, dvec3 from_m,
              double way_m, double length_m)
      : step_m_(0.5 * initial.spec().voxel_m()) {
    double own_end = 0, gap = 0;
    std::vector<double> left;
    size_t wanted = 0;
    for (double s = 0; s <= length_m; s += step_m_) {
      const dvec3 p = from_m + dvec3(way_m * s, 0, 0);
      if (initial.DistanceAt_m(p) >= 0) continue;
      if (initial.TissueAtPoint(p) == Tissue::kNeighbour) {
        gap = s - own_end;
        in_contact_ = own_end > 0 && gap <= kContactGap_m + step_m_;
        break;
      }
      own_end = s;
      if (reference.DistanceAt_m(p) < 0) ++wanted;
      if (attempt.DistanceAt_m(p) < 0) left.push_back(s);
    }
    left_ = static_cast<size_t>(
        std::ranges::count_if(left, [&](double s) { return s > own_end - kShell_m; }));
    in_contact_ = in_contact_ && wanted == 0;
  }
  bool in_contact() const { return in_contact_; }
  // Half a voxel is what rounding leaves of a plane.
  bool stands() const { return left_ > 1; }
  // A step more or less would change that.
  bool just_stands_or_falls() const { return left_ == 1 || left_ == 2; }

 private:
  const double step_m_;
  bool in_contact_ = false;
  size_t left_ = 0;
};

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
    out[s] = of > 0 && of >= kLeastSide * all ? static_cast<double>(done[s]) / of : 1;
  }
  return out;
}

ContactFigures MeasureContact(const Volume& initial, const Volume& attempt, const Volume& reference,
                              const OpenBox& target) {
  const double h = initial.spec().voxel_m();
  const double top =
      initial.spec().origin_m().z + static_cast<double>(initial.spec().voxels().z) * h;
  const double middle_x = 0.5 * (target.lo_m.x + target.hi_m.x);
  const double length = 0.5 * (target.hi_m.x - target.lo_m.x) + kReach_m;
  ContactFigures out;
  double standing = 0;
  for (double z = target.lo_m.z + 0.5 * h; z < top; z += h) {
    double row = 0;
    for (double y = target.lo_m.y + 0.5 * h; y < target.hi_m.y; y += h) {
      for (double way : {1.0, -1.0}) {
        const ContactLine line(initial, attempt, reference, {middle_x, y, z}, way, length);
        if (!line.in_contact()) continue;
        ++row;
        if (line.stands()) ++standing;
        if (line.just_stands_or_falls()) ++out.near;
      }
    }
    out.lines += row;
    out.longest_row = std::max(out.longest_row, row);
  }
  out.in_task = out.lines * h * h >= kLeastContact_m2;
  if (out.in_task) out.left = standing / out.lines;
  return out;
}

}  // namespace enamel::scoring
