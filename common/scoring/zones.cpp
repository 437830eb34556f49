#include "common/scoring/zones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/scene/builder.h"
#include "common/scene/tooth_number.h"
#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"
#include "common/scoring/hollow.h"

namespace enamel::scoring {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::SolidFraction;
using cutting::Volume;

constexpr int kSubCells = 2;  // along each axis of a voxel that a box face and a surface cut

OpenBox Grown(const OpenBox& box, int32_t side_um, int32_t bottom_um) {
  dvec3 side(side_um * 1e-6, side_um * 1e-6, 0);
  return {box.lo_m - side - dvec3(0, 0, bottom_um * 1e-6), box.hi_m + side, box.mesial_x};
}

// Share of [middle - half, middle + half] within [lo, hi].
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
      // Removal in a voxel that the face divides counts from the zone's side, where cuts come from.
      removed += std::min<double>(share * before, before - after) / 65536;
    }
  }
  const double voxel_m3 = h * h * h;
  return {solid * voxel_m3, removed * voxel_m3};
}

// The solid that `wanted` lacks, and how much of it was removed.
BoxVolume MeasureLacking(const Volume& initial, const Volume& final_volume, const Volume& wanted) {
  const GridSpec& spec = initial.spec();
  const ChangedBricks lacking(initial, wanted);
  int64_t solid = 0, removed = 0;  // 65536 to a voxel
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!lacking.Brick(b)) continue;
    const BrickSamples before(initial, b), after(final_volume, b), then(wanted, b);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int32_t all = before.Solid(i), asked = all - std::min(all, then.Solid(i));
      solid += asked;
      removed += std::min(asked, all - std::min(all, after.Solid(i)));
    }
  }
  const double unit_m3 = spec.voxel_m() * spec.voxel_m() * spec.voxel_m() / 65536;
  return {static_cast<double>(solid) * unit_m3, static_cast<double>(removed) * unit_m3};
}

// The tooth without what lies within `reach_m` of a hollow, for each reach, ascending.
class Grower {
 public:
  Grower(const Volume& initial, const Volume& prepared, std::array<double, 2> reach_m)
      : initial_(initial),
        lacking_(initial, prepared),
        hollow_(initial, prepared),
        reach_m_(reach_m) {
    grown_.fill(Volume(initial.spec()));
    const int bricks = static_cast<int>(initial.spec().brick_count());
    for (int b = 0; b < bricks; ++b) {
      const bool stored = initial.IsStored(b);
      if (stored || initial.UniformTissue(b) != cutting::Tissue::kAir) Brick(b);
    }
  }

  std::array<Volume, 2> Take() { return std::move(grown_); }

 private:
  void Brick(int b) {
    const GridSpec& spec = initial_.spec();
    const double h = spec.voxel_m(), band = 4 * h;
    const ivec3& n = spec.bricks;
    const ivec3 first = ivec3(b % n.x, b / n.x % n.y, b / (n.x * n.y)) * cutting::kBrickSide;
    const dvec3 corner = spec.origin_m() + dvec3(first) * h;
    const double half = 0.5 * (cutting::kBrickSide - 1) * std::sqrt(3.0) * h;
    const double limit = reach_m_[1] + band + half;
    // A brick in the middle of the hollow is as far from its surface, but it changed.
    const dvec3 middle = corner + 0.5 * (cutting::kBrickSide - 1) * h;
    if (!lacking_.Brick(b) && hollow_.ToCut_m(middle, limit) >= limit) {
      for (Volume& volume : grown_) scene::CopyBrick(initial_, b, volume);
      return;
    }
    std::array<std::array<int16_t, kBrickVoxels>, 2> phi;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int before = initial_.PhiAt(first + ivec3(i & 7, i >> 3 & 7, i >> 6));
      const dvec3 p = corner + dvec3(i & 7, i >> 3 & 7, i >> 6) * h;
      const double d = hollow_.Distance_m(p, limit);
      for (size_t k = 0; k < 2; ++k) {
        const double gone = std::clamp((reach_m_[k] - d) / h * cutting::kPhiPerVoxel,
                                       -1.0 * cutting::kPhiLimit, 1.0 * cutting::kPhiLimit);
        phi[k][static_cast<size_t>(i)] =
            static_cast<int16_t>(std::max(before, static_cast<int>(std::lround(gone))));
      }
    }
    std::span<const uint8_t> labels;
    if (initial_.HasLabels(b)) labels = initial_.Labels(b).tissue;
    for (size_t k = 0; k < 2; ++k)
      grown_[k].SetBrick(
          b, phi[k], labels,
          labels.empty() ? initial_.UniformTissue(b) : static_cast<cutting::Tissue>(labels[0]));
  }

  const Volume& initial_;
  const ChangedBricks lacking_;
  const Hollow hollow_;
  const std::array<double, 2> reach_m_;
  std::array<Volume, 2> grown_;
};

}  // namespace

Result<ZoneBoxes> BoxesOf(const scene::Scene& scene, const scene::CavityTarget& target) {
  ENAMEL_ASSIGN_OR_RETURN(const scene::PointUm at, scene::TargetPoint(scene, target));
  dvec3 top;
  for (int i = 0; i < 3; ++i) top[i] = at[static_cast<size_t>(i)] * 1e-6;
  dvec3 half(target.half_size_um[0] * 1e-6, target.half_size_um[1] * 1e-6, 0);
  ZoneBoxes boxes;
  boxes.leeway_growth = {target.leeway_side_um * 1e-6, target.leeway_bottom_um * 1e-6};
  boxes.container_growth = {boxes.leeway_growth.side_m + target.container_um * 1e-6,
                            boxes.leeway_growth.bottom_m + target.container_um * 1e-6};
  if (!target.prepared.IsZero()) {
    boxes.prepared = target.prepared_tooth;
    if (!boxes.prepared) {
      return Status(
          Code::kNotFound,
          "the target's prepared tooth (scene " + target.prepared.Hex() + ") was not loaded",
          "target.prepared_scene_sha256");
    }
    boxes.target = {boxes.prepared->lo_m, boxes.prepared->hi_m, scene::MesialX(scene.tooth)};
    boxes.leeway = Grown(boxes.target, target.leeway_side_um, target.leeway_bottom_um);
    boxes.container = Grown(boxes.leeway, target.container_um, target.container_um);
    return boxes;
  }
  boxes.target = {top - half - dvec3(0, 0, target.depth_um * 1e-6), top + half,
                  scene::MesialX(scene.tooth)};
  boxes.leeway = Grown(boxes.target, target.leeway_side_um, target.leeway_bottom_um);
  boxes.container = Grown(boxes.leeway, target.container_um, target.container_um);
  if (target.parts.empty()) return boxes;
  ENAMEL_ASSIGN_OR_RETURN(boxes.shape, scene::TargetShape(scene, target));
  return boxes;
}

double NearOf_m(const scene::CavityTarget& target, const cutting::GridSpec& grid) {
  return std::max(std::max(target.leeway_side_um, target.leeway_bottom_um) * 1e-6,
                  2 * grid.voxel_m());
}

BoxVolume MeasureZone(const Volume& initial, const Volume& final_volume, const ZoneBoxes& zones,
                      Zone zone) {
  if (zones.prepared) {
    ENAMEL_CHECK(zone == Zone::kTarget || zones.leeway_gone);
    return MeasureLacking(initial, final_volume,
                          zone == Zone::kTarget   ? zones.prepared->volume
                          : zone == Zone::kLeeway ? *zones.leeway_gone
                                                  : *zones.container_gone);
  }
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

void GrowZones(const Volume& initial, ZoneBoxes& zones) {
  if (!zones.prepared || zones.leeway_gone) return;
  auto grown = Grower(initial, zones.prepared->volume,
                      {zones.leeway_growth.side_m, zones.container_growth.side_m})
                   .Take();
  zones.leeway_gone = std::make_shared<const Volume>(std::move(grown[0]));
  zones.container_gone = std::make_shared<const Volume>(std::move(grown[1]));
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
