#include "common/scoring/zones.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace enamel::scoring {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::SolidFraction;
using cutting::Volume;

constexpr int kSubCells = 2;  // along each axis of a voxel that a box face and a surface cut

OpenBox Grown(const OpenBox& box, int32_t side_um, int32_t bottom_um) {
  dvec3 side(side_um * 1e-6, side_um * 1e-6, 0);
  return {box.lo_m - side - dvec3(0, 0, bottom_um * 1e-6), box.hi_m + side};
}

// Share of [middle - half, middle + half] that lies in [lo, hi].
double Overlap(double middle, double half, double lo, double hi) {
  double from = std::max(middle - half, lo), to = std::min(middle + half, hi);
  return to > from ? (to - from) / (2 * half) : 0;
}

// The box along one axis in voxels: which samples' cells it meets, and how much of each.
struct Span {
  int first = 0;
  std::vector<double> share;

  Span(double lo, double hi, int count) {
    // Sample i stands for the cell from i - 1/2 to i + 1/2.
    first = std::clamp(static_cast<int>(std::max(lo + 0.5, 0.0)), 0, count);
    int last = std::clamp(static_cast<int>(std::max(hi + 0.5, -1.0)), -1, count - 1);
    for (int i = first; i <= last; ++i) share.push_back(Overlap(i, 0.5, lo, hi));
  }
};

struct BoxMeter {
  const Volume& initial;
  const Volume& final_volume;
  const GridSpec& spec;
  dvec3 lo, hi;  // box in voxels
  double solid = 0, removed = 0;

  void AddCell(const ivec3& v, double share) {
    int32_t before = SolidFraction(initial.PhiAt(v));
    if (before == 0) return;
    int32_t after = SolidFraction(final_volume.PhiAt(v));
    bool cut_by_surface = before < 65536 || (after > 0 && after < 65536);
    if (share < 1 && cut_by_surface) {
      AddSubCells(v);
      return;
    }
    solid += share * before / 65536;
    removed += share * (before - after) / 65536;
  }

  // The part of voxel `v` inside the box, in kSubCells^3 pieces.
  void AddSubCells(const ivec3& v) {
    dvec3 from = glm::max(dvec3(v) - 0.5, lo), to = glm::min(dvec3(v) + 0.5, hi);
    dvec3 half = (to - from) * (0.5 / kSubCells);
    double weight = 8 * half.x * half.y * half.z;
    for (int z = 0; z < kSubCells; ++z) {
      for (int y = 0; y < kSubCells; ++y) {
        for (int x = 0; x < kSubCells; ++x) {
          dvec3 middle = from + (dvec3(x, y, z) * 2.0 + 1.0) * half;
          double before = SolidShare(initial, middle, half);
          // Nothing grows back: what interpolation says to the contrary is its error.
          double after = std::min(before, SolidShare(final_volume, middle, half));
          solid += weight * before;
          removed += weight * (before - after);
        }
      }
    }
  }

  // How much of a small box is solid, taking the distance as linear over it: exact for a surface
  // parallel to a face.
  double SolidShare(const Volume& volume, const dvec3& middle, const dvec3& half) const {
    auto phi = [&](const dvec3& p) {
      return volume.DistanceAt_m(spec.origin_m() + p * spec.voxel_m());
    };
    double width = 0;
    for (int i = 0; i < 3; ++i) {
      dvec3 step(0);
      step[i] = half[i];
      width += std::fabs(phi(middle + step) - phi(middle - step));
    }
    double here = phi(middle);
    if (width == 0) return here < 0 ? 1 : 0;
    return std::clamp(0.5 - here / width, 0.0, 1.0);
  }
};

// Removed units of one brick, booked to its tissues.
void AddBrick(const Volume& initial, const Volume& final_volume, int brick,
              std::array<int64_t, cutting::kTissueCount>& removed) {
  static constexpr auto kAllAir = [] {
    std::array<int16_t, kBrickVoxels> phi{};
    phi.fill(cutting::kPhiLimit);
    return phi;
  }();
  // A brick that is not stored was never cut, or has no solid left.
  if (!final_volume.IsStored(brick) && final_volume.UniformTissue(brick) != cutting::Tissue::kAir) {
    return;
  }
  const auto& after = final_volume.IsStored(brick) ? final_volume.Phi(brick).phi : kAllAir;
  auto uniform = static_cast<size_t>(initial.UniformTissue(brick));
  if (!initial.IsStored(brick)) {
    if (uniform == 0) return;
    for (int16_t phi : after) removed[uniform] += 65536 - SolidFraction(phi);
    return;
  }
  const auto& before = initial.Phi(brick).phi;
  if (before == after) return;
  const uint8_t* labels = initial.HasLabels(brick) ? initial.Labels(brick).tissue.data() : nullptr;
  for (size_t i = 0; i < kBrickVoxels; ++i) {
    removed[labels ? labels[i] : uniform] += SolidFraction(before[i]) - SolidFraction(after[i]);
  }
}

// Brick by brick: one question for a brick that lies wholly in or out, which most do.
BoxVolume MeasureShape(const Volume& initial, const Volume& final_volume,
                       const scene::Preparation& shape, const scene::Growth& grown) {
  const GridSpec& spec = initial.spec();
  const double h = spec.voxel_m(), middle = 0.5 * (cutting::kBrickSide - 1);
  const double reach = (middle + 1) * std::sqrt(3.0) * h * scene::DistanceErrs(shape);
  double solid = 0, removed = 0;
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!initial.IsStored(b) && initial.UniformTissue(b) == cutting::Tissue::kAir) continue;
    const ivec3& n = spec.bricks;
    const ivec3 first = ivec3(b % n.x, b / n.x % n.y, b / (n.x * n.y)) * cutting::kBrickSide;
    const dvec3 corner = spec.origin_m() + dvec3(first) * h;
    const double distance = scene::PreparationDistance_m(shape, corner + middle * h, grown);
    if (distance > reach) continue;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 in_brick(i & 7, i >> 3 & 7, i >> 6);
      const int32_t before = SolidFraction(initial.PhiAt(first + in_brick));
      if (before == 0) continue;
      double share = 1;
      if (distance > -reach) {
        const double d = scene::PreparationDistance_m(shape, corner + dvec3(in_brick) * h, grown);
        share = std::clamp(0.5 - d / h, 0.0, 1.0);
      }
      // Nothing grows back.
      const int32_t after = std::min(before, SolidFraction(final_volume.PhiAt(first + in_brick)));
      solid += share * before / 65536;
      // What went of a voxel that the face divides went from the zone's side, where cuts come from.
      removed += std::min<double>(share * before, before - after) / 65536;
    }
  }
  const double voxel_m3 = h * h * h;
  return {solid * voxel_m3, removed * voxel_m3};
}

}  // namespace

Result<ZoneBoxes> BoxesOf(const scene::Scene& scene, const scene::CavityTarget& target) {
  ENAMEL_ASSIGN_OR_RETURN(const scene::PointUm at, scene::TargetPoint(scene, target));
  dvec3 top;
  for (int i = 0; i < 3; ++i) top[i] = at[static_cast<size_t>(i)] * 1e-6;
  dvec3 half(target.half_size_um[0] * 1e-6, target.half_size_um[1] * 1e-6, 0);
  ZoneBoxes boxes;
  boxes.target = {top - half - dvec3(0, 0, target.depth_um * 1e-6), top + half};
  boxes.leeway = Grown(boxes.target, target.leeway_side_um, target.leeway_bottom_um);
  boxes.container = Grown(boxes.leeway, target.container_um, target.container_um);
  if (target.parts.empty()) return boxes;
  ENAMEL_ASSIGN_OR_RETURN(boxes.shape, scene::TargetShape(scene, target));
  boxes.leeway_growth = {target.leeway_side_um * 1e-6, target.leeway_bottom_um * 1e-6};
  boxes.container_growth = {boxes.leeway_growth.side_m + target.container_um * 1e-6,
                            boxes.leeway_growth.bottom_m + target.container_um * 1e-6};
  return boxes;
}

double NearOf_m(const scene::CavityTarget& target, const cutting::GridSpec& grid) {
  return std::max(std::max(target.leeway_side_um, target.leeway_bottom_um) * 1e-6,
                  2 * grid.voxel_m());
}

BoxVolume MeasureZone(const Volume& initial, const Volume& final_volume, const ZoneBoxes& zones,
                      Zone zone) {
  if (!zones.shape) {
    return MeasureBox(initial, final_volume,
                      zone == Zone::kTarget   ? zones.target
                      : zone == Zone::kLeeway ? zones.leeway
                                              : zones.container);
  }
  const scene::Growth grown = zone == Zone::kTarget   ? scene::Growth{}
                              : zone == Zone::kLeeway ? zones.leeway_growth
                                                      : zones.container_growth;
  return MeasureShape(initial, final_volume, *zones.shape, grown);
}

BoxVolume MeasureBox(const Volume& initial, const Volume& final_volume, const OpenBox& box) {
  const GridSpec& spec = initial.spec();
  double h = spec.voxel_m();
  ivec3 count = spec.voxels();
  BoxMeter meter{initial, final_volume, spec, (box.lo_m - spec.origin_m()) / h,
                 (box.hi_m - spec.origin_m()) / h};
  meter.hi.z = count.z;  // open at the top: to the end of the grid
  Span xs(meter.lo.x, meter.hi.x, count.x), ys(meter.lo.y, meter.hi.y, count.y),
      zs(meter.lo.z, meter.hi.z, count.z);
  for (size_t z = 0; z < zs.share.size(); ++z) {
    for (size_t y = 0; y < ys.share.size(); ++y) {
      double share_yz = ys.share[y] * zs.share[z];
      for (size_t x = 0; x < xs.share.size(); ++x) {
        ivec3 v(xs.first + static_cast<int>(x), ys.first + static_cast<int>(y),
                zs.first + static_cast<int>(z));
        if (double share = xs.share[x] * share_yz; share > 0) meter.AddCell(v, share);
      }
    }
  }
  return {meter.solid * h * h * h, meter.removed * h * h * h};
}

std::array<double, cutting::kTissueCount> RemovedPerTissue_m3(const Volume& initial,
                                                              const Volume& final_volume) {
  std::array<int64_t, cutting::kTissueCount> units{};
  for (int b = 0; b < initial.spec().brick_count(); ++b) AddBrick(initial, final_volume, b, units);
  double h = initial.spec().voxel_m();
  std::array<double, cutting::kTissueCount> out{};
  for (size_t t = 0; t < units.size(); ++t) {
    out[t] = static_cast<double>(units[t]) * (h * h * h / 65536);
  }
  return out;
}

}  // namespace enamel::scoring
