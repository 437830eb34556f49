#include "common/scene/preparation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>

#include "common/scene/builder.h"

namespace enamel::scene {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

// To a rectangle about 0, exact.
double RectangleDistance(double x, double y, double hx, double hy) {
  x = std::abs(x) - hx, y = std::abs(y) - hy;
  const double ox = std::max(x, 0.0), oy = std::max(y, 0.0);
  return std::sqrt(ox * ox + oy * oy) + std::min(std::max(x, y), 0.0);
}

// To a simple polygon: to its nearest side, negative where a line to the right crosses an odd
// number of sides.
double PolygonDistance_m(const std::vector<std::array<int32_t, 2>>& corners_um, double x,
                         double y) {
  double nearest = 1e30;
  bool inside = false;
  for (size_t i = 0, j = corners_um.size() - 1; i < corners_um.size(); j = i++) {
    const double ax = corners_um[j][0] * 1e-6, ay = corners_um[j][1] * 1e-6;
    const double ex = corners_um[i][0] * 1e-6 - ax, ey = corners_um[i][1] * 1e-6 - ay;
    const double px = x - ax, py = y - ay;
    const double along = std::clamp((px * ex + py * ey) / (ex * ex + ey * ey), 0.0, 1.0);
    const double dx = px - along * ex, dy = py - along * ey;
    nearest = std::min(nearest, dx * dx + dy * dy);
    if ((py < 0) != (py < ey) && (px * ey < py * ex) == (ey > 0)) inside = !inside;
  }
  return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

// To what stands, from the opening's middle; `thinner_m` off its walls, without its table.
double StumpWallDistance_m(const PreparationPart& part, const dvec3& d, double thinner_m) {
  const Stump& s = part.stump;
  const double height = (part.depth_um - s.table_below_um) * 1e-6;
  // Above the table and under the foot the walls continue as between them.
  const double t = (d.z + part.depth_um * 1e-6) / height;
  auto mix = [&](int32_t foot_um, int32_t table_um) {
    return foot_um * 1e-6 + (table_um - foot_um) * 1e-6 * t;
  };
  const double hx = std::max(1e-5, mix(s.foot.half_um[0], s.table.half_um[0]) - thinner_m);
  const double hy = std::max(1e-5, mix(s.foot.half_um[1], s.table.half_um[1]) - thinner_m);
  const double radius = std::clamp(s.corner_um * 1e-6 - thinner_m, 0.0, std::min(hx, hy));
  const double beside = RectangleDistance(d.x - mix(s.foot.middle_um[0], s.table.middle_um[0]),
                                          d.y - mix(s.foot.middle_um[1], s.table.middle_um[1]),
                                          hx - radius, hy - radius) -
                        radius;
  const double slope =
      std::max(s.foot.half_um[0] - s.table.half_um[0], s.foot.half_um[1] - s.table.half_um[1]) *
      1e-6 / height;
  return beside / std::sqrt(1 + slope * slope);
}

double PartDistance_m(const PreparationPart& part, const dvec3& p, const Growth& grown) {
  using Outline = PreparationPart::Outline;
  dvec3 d = p - dvec3(part.top_um[0], part.top_um[1], part.top_um[2]) * 1e-6;
  double hx = part.half_size_um[0] * 1e-6 + grown.side_m;
  double hy = part.half_size_um[1] * 1e-6 + grown.side_m;
  // There is no upper end, so that nothing of the tooth is left above the part.
  const bool relief = part.relief.step_um != 0, stump = part.outline == Outline::kStump;
  double below = -d.z - (part.depth_um * 1e-6 + grown.bottom_m);
  if (relief && !stump) below = -HeightOverRelief_m(part, p + dvec3(0, 0, grown.bottom_m));
  double side;
  if (part.outline == Outline::kDisc) {
    side = std::sqrt(d.x * d.x + d.y * d.y) - hx;
  } else if (part.outline == Outline::kPolygon) {
    side = PolygonDistance_m(part.corners_um, d.x, d.y) - grown.side_m;
  } else {
    side = RectangleDistance(d.x, d.y, hx, hy);
  }
  // Outline and floor put together as two half spaces are: outside by Pythagoras, inside the
  // nearer.
  double ox = std::max(side, 0.0), oz = std::max(below, 0.0);
  const double hollow = std::sqrt(ox * ox + oz * oz) + std::min(std::max(side, below), 0.0);
  if (!stump) return hollow;
  // The table is a floor, too.
  const dvec3 lower = d + dvec3(0, 0, grown.bottom_m);
  const double over_table = relief ? HeightOverRelief_m(part, p + dvec3(0, 0, grown.bottom_m))
                                   : lower.z + part.stump.table_below_um * 1e-6;
  const double standing = std::max(StumpWallDistance_m(part, lower, grown.side_m), over_table);
  return std::max(hollow, -standing);
}

int16_t Hollowed(int phi, double distance_m, double voxel_m) {
  double limit = kPhiLimit;
  // The hollow's inside is the tooth's air, hence the sign.
  double hollow = std::clamp(-distance_m / voxel_m * cutting::kPhiPerVoxel, -limit, limit);
  return static_cast<int16_t>(std::max(phi, static_cast<int>(std::lround(hollow))));
}

Tissue LabelOf(const Volume& volume, int brick, size_t i) {
  return volume.HasLabels(brick) ? static_cast<Tissue>(volume.Labels(brick).tissue[i])
                                 : volume.UniformTissue(brick);
}

using Distance = std::function<double(const dvec3& point_m)>;

void HollowBrick(const Volume& from, int brick, const dvec3& corner, const Distance& distance_m,
                 Neighbours neighbours, Volume& to) {
  double h = from.spec().voxel_m();
  std::array<int16_t, kBrickVoxels> phi;
  for (int i = 0; i < kBrickVoxels; ++i) {
    const auto n = static_cast<size_t>(i);
    dvec3 p = corner + h * dvec3(i % kBrickSide, i / kBrickSide % kBrickSide, i / 64);
    const int before = from.IsStored(brick) ? from.Phi(brick).phi[n] : -kPhiLimit;
    const bool spared =
        neighbours == Neighbours::kSpared && LabelOf(from, brick, n) == Tissue::kNeighbour;
    const bool stays = spared || before == kPhiLimit;
    phi[n] = stays ? static_cast<int16_t>(before) : Hollowed(before, distance_m(p), h);
  }
  if (std::all_of(phi.begin(), phi.end(), [](int16_t v) { return v == kPhiLimit; })) return;
  std::span<const uint8_t> labels;
  if (from.HasLabels(brick)) labels = from.Labels(brick).tissue;
  to.SetBrick(brick, phi, labels,
              labels.empty() ? from.UniformTissue(brick) : static_cast<Tissue>(labels[0]));
}

// How far a target's part goes from the landmark, to whichever side is farther, and below it.
struct PartReach {
  std::array<int32_t, 2> side_um{};
  int32_t depth_um = 0;
};
PartReach ReachOf(const PreparationPart& part) {
  PartReach out;
  for (size_t i = 0; i < 2; ++i) {
    out.side_um[i] = std::abs(part.top_um[i]) + part.half_size_um[i];
    if (part.outline != PreparationPart::Outline::kPolygon) continue;
    out.side_um[i] = 0;
    for (const auto& corner : part.corners_um)
      out.side_um[i] = std::max(out.side_um[i], std::abs(part.top_um[i] + corner[i]));
  }
  out.depth_um = part.depth_um - part.top_um[2];
  return out;
}

}  // namespace

ReliefPoint ReliefAt(const PreparationPart& part, double x_m, double y_m) {
  const Relief& r = part.relief;
  // In steps from the grid's first point; beyond its ends as at them.
  auto place = [&](double offset_m, int32_t count, double& t, bool& beyond) {
    const double at = offset_m / (r.step_um * 1e-6) + 0.5 * (count - 1);
    const double held = std::clamp(at, 0.0, static_cast<double>(count - 1));
    beyond = held != at;
    const int first = std::min(static_cast<int>(held), std::max(0, count - 2));
    t = held - first;
    return first;
  };
  double tx = 0, ty = 0;
  bool beyond_x = false, beyond_y = false;
  const int i = place(x_m - part.top_um[0] * 1e-6, r.count[0], tx, beyond_x);
  const int j = place(y_m - part.top_um[1] * 1e-6, r.count[1], ty, beyond_y);
  auto below = [&](int x, int y) {
    x = std::min(x, r.count[0] - 1), y = std::min(y, r.count[1] - 1);
    return r.below_um[static_cast<size_t>(y * r.count[0] + x)] * 1e-6;
  };
  const double a = below(i, j), b = below(i + 1, j), c = below(i, j + 1), d = below(i + 1, j + 1);
  const double step_m = r.step_um * 1e-6;
  const double lower = a + tx * (b - a), upper = c + tx * (d - c);
  ReliefPoint out;
  out.z_m = part.top_um[2] * 1e-6 - (lower + ty * (upper - lower));
  if (!beyond_x) out.rise_x = -((1 - ty) * (b - a) + ty * (d - c)) / step_m;
  if (!beyond_y) out.rise_y = -(upper - lower) / step_m;
  return out;
}

double HeightOverRelief_m(const PreparationPart& part, const dvec3& p) {
  const ReliefPoint at = ReliefAt(part, p.x, p.y);
  return (p.z - at.z_m) / std::sqrt(1 + at.rise_x * at.rise_x + at.rise_y * at.rise_y);
}

double PreparationDistance_m(const Preparation& preparation, const dvec3& point_m,
                             const Growth& grown) {
  double d = PartDistance_m(preparation.parts.at(0), point_m, grown);
  for (const PreparationPart& part : preparation.parts)
    d = std::min(d, PartDistance_m(part, point_m, grown));
  return d;
}

double DistanceErrs(const Preparation& preparation) {
  const auto& parts = preparation.parts;
  const bool relief =
      std::any_of(parts.begin(), parts.end(), [](const auto& p) { return p.relief.step_um != 0; });
  return relief ? 2 : 1;
}

Result<PointUm> TargetPoint(const Scene& scene, const CavityTarget& target) {
  auto landmark = scene.landmarks.find(target.landmark);
  if (landmark != scene.landmarks.end()) return landmark->second;
  return Status(Code::kInvalidInput,
                "the target hangs from landmark \"" + target.landmark + "\", which scene \"" +
                    scene.name + "\" does not have: add it to the scene or choose another",
                "target.landmark");
}

Result<Preparation> TargetShape(const Scene& scene, const CavityTarget& target) {
  ENAMEL_ASSIGN_OR_RETURN(const PointUm at, TargetPoint(scene, target));
  Preparation out{target.landmark, "", target.parts};
  if (out.parts.empty()) {
    PreparationPart box;
    box.half_size_um = {target.half_size_um[0], target.half_size_um[1]};
    box.depth_um = target.depth_um;
    out.parts.push_back(box);
  }
  for (PreparationPart& part : out.parts)
    for (size_t i = 0; i < 3; ++i) part.top_um[i] += at[i];
  return out;
}

Volume CutAway(const Volume& volume, const Distance& distance_m, double errs,
               Neighbours neighbours) {
  // Farther from a brick's middle, nothing comes within the band of any of its samples.
  constexpr double kHalfDiagonalVoxels = 3.5 * 1.7320508075688772, kBandVoxels = 4;
  const GridSpec& spec = volume.spec();
  const double h = spec.voxel_m(), far_m = errs * (kHalfDiagonalVoxels + kBandVoxels) * h;
  Volume out(spec);
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) {
        int brick = spec.BrickIndex({x, y, z});
        bool air = !volume.IsStored(brick) && volume.UniformTissue(brick) == Tissue::kAir;
        dvec3 corner = spec.origin_m() + h * kBrickSide * dvec3(x, y, z);
        if (air || distance_m(corner + 3.5 * h) > far_m) {
          CopyBrick(volume, brick, out);
        } else {
          HollowBrick(volume, brick, corner, distance_m, neighbours, out);
        }
      }
  return out;
}

Volume Prepared(const Volume& volume, const Preparation& preparation, Neighbours neighbours) {
  return CutAway(
      volume, [&](const dvec3& p) { return PreparationDistance_m(preparation, p); },
      DistanceErrs(preparation), neighbours);
}

CavityTarget TargetFor(const Preparation& preparation) {
  CavityTarget target;
  target.landmark = preparation.name;
  const PointUm origin = preparation.parts.at(0).top_um;
  for (PreparationPart part : preparation.parts) {
    for (size_t i = 0; i < 3; ++i) part.top_um[i] -= origin[i];
    const PartReach reach = ReachOf(part);
    for (size_t i = 0; i < 2; ++i)
      target.half_size_um[i] = std::max(target.half_size_um[i], reach.side_um[i]);
    target.depth_um = std::max(target.depth_um, reach.depth_um);
    target.parts.push_back(std::move(part));
  }
  if (target.parts.size() == 1 && target.parts[0].outline == PreparationPart::Outline::kBox &&
      target.parts[0].relief.step_um == 0) {
    target.parts.clear();
  }
  return target;
}

bool HoldsItsParts(const CavityTarget& target) {
  return std::all_of(target.parts.begin(), target.parts.end(), [&](const PreparationPart& part) {
    const PartReach reach = ReachOf(part);
    return reach.side_um[0] <= target.half_size_um[0] &&
           reach.side_um[1] <= target.half_size_um[1] && reach.depth_um <= target.depth_um;
  });
}

}  // namespace enamel::scene
