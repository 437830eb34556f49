#include "station/lab/grades/hollow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/scene/builder.h"
#include "common/scene/preparation.h"

namespace enamel::station::lab {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

constexpr int kWaves = 3;

// In the wall's own frame: distance out, along it and above the cavity's middle height.
double WallDistance_m(const Face& f, double out, double along, double length, double height) {
  const double wave = f.wave_m * std::sin(2 * std::numbers::pi * kWaves * along / length);
  // Accurate to second order in the slope.
  return (out - f.moved_m - wave - f.slope * height) / std::sqrt(1 + f.slope * f.slope);
}

dvec3 CornerOf(const cutting::GridSpec& spec, int brick) {
  const ivec3& n = spec.bricks;
  return spec.origin_m() +
         dvec3(brick % n.x, brick / n.x % n.y, brick / (n.x * n.y)) * (kBrickSide * spec.voxel_m());
}

dvec3 InBrick(int i) { return {i & 7, i >> 3 & 7, i >> 6}; }

bool IsAir(const Volume& volume, int brick) {
  return !volume.IsStored(brick) && volume.UniformTissue(brick) == Tissue::kAir;
}

Tissue LabelOf(const Volume& volume, int brick, int i) {
  return volume.HasLabels(brick)
             ? static_cast<Tissue>(volume.Labels(brick).tissue[static_cast<size_t>(i)])
             : volume.UniformTissue(brick);
}

}  // namespace

double NothingTaken(const dvec3&) { return 1; }
double EverythingTaken(const dvec3&) { return -1; }

double BoxDistance_m(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  const dvec3 d = glm::max(lo - p, p - hi), out = glm::max(d, dvec3(0));
  return std::sqrt(Dot(out, out)) + std::min(0.0, std::max({d.x, d.y, d.z}));
}

Hollow Both(Hollow a, Hollow b) {
  return [a = std::move(a), b = std::move(b)](const dvec3& p) { return std::min(a(p), b(p)); };
}

Hollow Turned(Hollow hollow, double degrees) {
  const double c = std::cos(degrees * std::numbers::pi / 180),
               s = std::sin(degrees * std::numbers::pi / 180);
  return [=, hollow = std::move(hollow)](const dvec3& p) {
    return hollow(dvec3(c * p.x + s * p.y, c * p.y - s * p.x, p.z));
  };
}

double BoxCavity::Distance_m(const dvec3& point_m) const {
  const dvec3 p = point_m - centre_m;
  const double height = p.z + 0.5 * depth_m;
  const auto& f = faces;
  const double mesially = mesial_x * p.x;
  const double x = std::max(WallDistance_m(f[0], mesially - half_x_m, p.y, 2 * half_y_m, height),
                            WallDistance_m(f[1], -mesially - half_x_m, p.y, 2 * half_y_m, height));
  const double y = std::max(WallDistance_m(f[2], p.y - half_y_m, p.x, 2 * half_x_m, height),
                            WallDistance_m(f[3], -p.y - half_y_m, p.x, 2 * half_x_m, height));
  const double below = WallDistance_m(f[4], -p.z - depth_m, p.x, 2 * half_x_m, p.x);
  return std::max({x, y, below});
}

CrownCut CrownCut::Moved(double in_m, double lower_m) const {
  CrownCut out = *this;
  out.top_z_m -= lower_m;
  out.table_lower_m += lower_m;
  for (Section* s : {&out.at_shoulder, &out.at_top}) s->half_x_m -= in_m, s->half_y_m -= in_m;
  out.corner_m -= in_m;
  return out;
}

CrownCut CrownCut::Deeper(double lower_m) const {
  CrownCut out = *this;
  out.shoulder_z_m -= lower_m;
  const double on = lower_m / (top_z_m - shoulder_z_m);
  auto go_on = [&](double Section::*member) {
    out.at_shoulder.*member += on * (at_shoulder.*member - at_top.*member);
  };
  for (auto member :
       {&Section::middle_x_m, &Section::middle_y_m, &Section::half_x_m, &Section::half_y_m}) {
    go_on(member);
  }
  return out;
}

CrownCut CrownCut::Converging(double degrees) const {
  CrownCut out = *this;
  const double in = std::tan(degrees / 2 * std::numbers::pi / 180) * (top_z_m - shoulder_z_m);
  out.at_top.middle_x_m = at_shoulder.middle_x_m;
  out.at_top.half_x_m = at_shoulder.half_x_m - in;
  return out;
}

CrownCut CrownCut::Undercut(double degrees) const {
  CrownCut out = *this;
  const double in = std::tan(degrees / 2 * std::numbers::pi / 180) * (top_z_m - shoulder_z_m);
  out.at_shoulder.middle_x_m = at_top.middle_x_m;
  out.at_shoulder.half_x_m = at_top.half_x_m + in;
  return out;
}

bool CrownCut::HasTop() const {
  constexpr double kMinHalf_m = 0.2e-3;
  return std::min(at_top.half_x_m, at_top.half_y_m) > kMinHalf_m;
}

CrownCut CrownCut::Leaning(double degrees) const {
  CrownCut out = *this;
  const double aside = std::tan(degrees * std::numbers::pi / 180) * (top_z_m - shoulder_z_m);
  out.at_top.middle_x_m = at_shoulder.middle_x_m + aside;
  out.at_top.middle_y_m = at_shoulder.middle_y_m;
  return out;
}

double CrownCut::Lean_deg() const {
  const double height = top_z_m - shoulder_z_m;
  const double in = (at_shoulder.half_x_m - at_top.half_x_m) / height;
  const double aside = (at_top.middle_x_m - at_shoulder.middle_x_m) / height;
  return std::fabs(std::atan(in + aside) - std::atan(in - aside)) / 2 * 180 / std::numbers::pi;
}

double CrownCut::OverTop_m(const dvec3& p) const {
  return table ? scene::HeightOverRelief_m(*table, p + dvec3(0, 0, table_lower_m)) : p.z - top_z_m;
}

double CrownCut::Distance_m(const dvec3& p) const {
  const double height = top_z_m - shoulder_z_m;
  // The walls continue above the top and under the shoulder with the same slope.
  const double t = (p.z - shoulder_z_m) / height;
  auto mix = [&](double a, double b) { return a + (b - a) * t; };
  const Section &a = at_shoulder, &b = at_top;
  const double half_x = std::max(1e-5, mix(a.half_x_m, b.half_x_m));
  const double half_y = std::max(1e-5, mix(a.half_y_m, b.half_y_m));
  const double radius = std::clamp(corner_m, 0.0, std::min(half_x, half_y));
  const double x = std::fabs(p.x - mix(a.middle_x_m, b.middle_x_m)) - half_x + radius;
  const double y = std::fabs(p.y - mix(a.middle_y_m, b.middle_y_m)) - half_y + radius;
  const double ox = std::max(x, 0.0), oy = std::max(y, 0.0);
  const double beside = std::sqrt(ox * ox + oy * oy) + std::min(std::max(x, y), 0.0) - radius;
  const double slope = std::max(a.half_x_m - b.half_x_m, a.half_y_m - b.half_y_m) / height;
  const double outside_stump = std::max(beside / std::sqrt(1 + slope * slope), OverTop_m(p));
  double shoulder = shoulder_z_m;
  if (wave_m != 0) {
    shoulder += wave_m * std::sin(4 * std::atan2(p.y - a.middle_y_m, p.x - a.middle_x_m));
  }
  return std::max(-outside_stump, shoulder - p.z);
}

Hollow Cut(const CrownCut& as) {
  return [as](const dvec3& p) { return as.Distance_m(p); };
}

CrownCut CrownCutOf(const scene::PreparationPart& part) {
  const scene::Stump& s = part.stump;
  auto section = [&](const scene::Stump::Section& at) -> CrownCut::Section {
    return {(part.top_um[0] + at.middle_um[0]) * 1e-6, (part.top_um[1] + at.middle_um[1]) * 1e-6,
            at.half_um[0] * 1e-6, at.half_um[1] * 1e-6};
  };
  CrownCut out;
  out.shoulder_z_m = (part.top_um[2] - part.depth_um) * 1e-6;
  out.top_z_m = (part.top_um[2] - s.table_below_um) * 1e-6;
  out.at_shoulder = section(s.foot);
  out.at_top = section(s.table);
  out.corner_m = s.corner_um * 1e-6;
  if (part.relief.step_um != 0) out.table = part;
  return out;
}

Volume CutAway(const Volume& initial, const Hollow& hollow, Neighbours neighbours) {
  constexpr double kErrs = 2;  // a wavy wall's distance
  return scene::CutAway(initial, hollow, kErrs, neighbours);
}

double VolumeWhere_m3(const Volume& initial, const dvec3& lo_m, const dvec3& hi_m,
                      const std::function<bool(const dvec3&, Tissue)>& counts,
                      const Hollow& within) {
  const cutting::GridSpec& spec = initial.spec();
  const double h = spec.voxel_m();
  constexpr int kParts = 3;
  int64_t found = 0;
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (IsAir(initial, b)) continue;
    const dvec3 corner = CornerOf(spec, b), end = corner + kBrickSide * h;
    if (glm::any(glm::lessThan(end, lo_m)) || glm::any(glm::greaterThan(corner - h, hi_m))) {
      continue;
    }
    const double half = 0.5 * (kBrickSide - 1);
    if (within && within(corner + half * h) > 2 * (half + 1) * std::sqrt(3.0) * h) continue;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const dvec3 at = corner + InBrick(i) * h;
      // No part's middle is farther than 0.6 h from the voxel's.
      if (initial.DistanceAt_m(at) > h || (within && within(at) > 2 * h)) continue;
      const Tissue tissue = LabelOf(initial, b, i);
      for (int k = 0; k < kParts * kParts * kParts; ++k) {
        const dvec3 p = at + (dvec3(k % kParts, k / kParts % kParts, k / (kParts * kParts)) - 1.0) *
                                 (h / kParts);
        if (initial.DistanceAt_m(p) < 0 && counts(p, tissue)) ++found;
      }
    }
  }
  return static_cast<double>(found) * h * h * h / (kParts * kParts * kParts);
}

dvec3 BlockCariesMiddle_m() { return {0.2e-3, -0.1e-3, -1.9e-3}; }

Volume FaultBlock(const BlockGrid& grid) {
  cutting::GridSpec spec;
  spec.voxel_nm = grid.voxel_nm;
  auto nm = [&](double mm) {
    return static_cast<int64_t>(std::llround(mm * 1e6 + grid.shift_m * 1e9));
  };
  spec.origin_nm = {nm(-4.2), nm(-3.7), nm(-4.7)};
  const double side_mm = kBrickSide * grid.voxel_nm * 1e-6;
  auto bricks = [&](double mm) { return static_cast<int>(mm / side_mm) + 1; };
  spec.bricks = ivec3(bricks(9.6), bricks(7.4), bricks(5.4));
  const dvec3 lo(-3.5e-3, -3e-3, -4e-3), hi(3.5e-3, 3e-3, 0);
  const dvec3 next_lo(kBlockNeighbour_m, -3e-3, -4e-3), next_hi(4.7e-3, 3e-3, 0);
  const dvec3 caries = BlockCariesMiddle_m();
  return scene::BuildVolume(spec, [=](const dvec3& p) -> scene::FieldSample {
    const double distance = std::min(BoxDistance_m(p, lo, hi), BoxDistance_m(p, next_lo, next_hi));
    if (p.x > 0.5 * (hi.x + next_lo.x)) return {distance, Tissue::kNeighbour};
    const dvec3 d = p - caries;
    if (Dot(d, d) < kBlockCaries_m * kBlockCaries_m) return {distance, Tissue::kCaries};
    return {distance, p.z > -1.2e-3   ? Tissue::kEnamel
                      : p.z > -3.2e-3 ? Tissue::kDentin
                                      : Tissue::kPulp};
  });
}

BoxCavity FaultBlockCavity() { return {dvec3(0), 1.5e-3, 1.2e-3, 2e-3, {}}; }

}  // namespace enamel::station::lab
