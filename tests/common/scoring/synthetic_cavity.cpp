#include "tests/common/scoring/synthetic_cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/cutting/cutter.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kMm = 1e-3;
const dvec3 kBlockLo_mm(-3.5, -3, -4), kBlockHi_mm(3.5, 3, 0);

double BoxDistance(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  dvec3 d = glm::max(lo - p, p - hi);
  dvec3 out = glm::max(d, dvec3(0));
  return std::sqrt(Dot(out, out)) + std::min(0.0, std::max(d.x, std::max(d.y, d.z)));
}

Tissue TissueAtDepth(double depth_mm) {
  return depth_mm < 1.2 ? Tissue::kEnamel : depth_mm < 2.8 ? Tissue::kDentin : Tissue::kPulp;
}

void FillBrick(Volume& volume, const ivec3& brick) {
  const cutting::GridSpec& spec = volume.spec();
  std::array<int16_t, cutting::kBrickVoxels> phi;
  std::array<uint8_t, cutting::kBrickVoxels> labels;
  size_t at = 0;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x, ++at) {
        dvec3 p = (spec.origin_m() + dvec3(brick * 8 + ivec3(x, y, z)) * spec.voxel_m()) / kMm;
        double voxels = BoxDistance(p, kBlockLo_mm, kBlockHi_mm) * kMm / spec.voxel_m();
        double units = std::clamp(voxels * cutting::kPhiPerVoxel, -32767.0, 32767.0);
        phi[at] = static_cast<int16_t>(std::lround(units));
        labels[at] = static_cast<uint8_t>(TissueAtDepth(-p.z));
      }
    }
  }
  int index = spec.BrickIndex(brick);
  auto same = [](const auto& values, auto v) {
    return std::all_of(values.begin(), values.end(), [&](auto w) { return w == v; });
  };
  if (same(phi, cutting::kPhiLimit)) return;
  bool one_tissue = same(labels, labels[0]);
  if (one_tissue && same(phi, static_cast<int16_t>(-cutting::kPhiLimit))) {
    volume.SetUniform(index, static_cast<Tissue>(labels[0]));
  } else if (one_tissue) {
    volume.SetBrick(index, phi, {}, static_cast<Tissue>(labels[0]));
  } else {
    volume.SetBrick(index, phi, labels, Tissue::kEnamel);
  }
}

Quat Rotation(const dvec3& axis, double tangent_of_half) {
  return Quat{axis.x * tangent_of_half, axis.y * tangent_of_half, axis.z * tangent_of_half, 1}
      .Normalised();
}

}  // namespace

Volume MakeBlock(int32_t voxel_nm, int64_t up_nm) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  spec.origin_nm = {-4'013'000, -3'507'000, -4'519'000 + up_nm};
  double side = cutting::kBrickSide * voxel_nm * 1e-6;
  spec.bricks = ivec3(static_cast<int>(8.1 / side) + 1, static_cast<int>(7.1 / side) + 1,
                      static_cast<int>(5.1 / side) + 1);
  Volume volume(spec);
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) FillBrick(volume, ivec3(x, y, z));
  volume.Reserve();
  return volume;
}

Volume CutCavity(const Volume& block, const Cavity& c) {
  Volume volume = block;
  volume.Reserve();
  cutting::Cutter cutter(volume, {cutting::BurShape::kCylinder, kBurRadius_mm * kMm, 4e-3});
  cutting::RemovedUnits removed{};
  Quat turn = Rotation({0, 0, 1}, c.turn), tilt = Rotation({1, 0, 0}, c.tilt);
  dmat3 around = turn.Matrix();
  double step = 0.5 * volume.spec().voxel_m() / kMm, r = kBurRadius_mm;
  auto sweep = [&](dvec3 a, dvec3 b) {
    int n = static_cast<int>(std::ceil(std::sqrt(Dot(b - a, b - a)) / step)) + 1;
    for (int i = 0; i <= n; ++i) {
      dvec3 p = a + (b - a) * (static_cast<double>(i) / n);
      cutter.Cut({around * p * kMm, turn * tilt}, removed);
    }
  };
  double x0 = -c.distal_mm + r, x1 = c.mesial_mm - r, y0 = -c.lingual_mm + r, y1 = c.buccal_mm - r;
  int passes = static_cast<int>((y1 - y0) / r) + 2;
  for (int i = 0; i <= passes; ++i) {
    double y = y0 + (y1 - y0) * i / passes;
    sweep({x0, y, -c.depth_mm}, {x1, y, -c.depth_mm});
  }
  sweep({x0, y0, -c.depth_mm}, {x0, y1, -c.depth_mm});
  sweep({x1, y0, -c.depth_mm}, {x1, y1, -c.depth_mm});
  return volume;
}

scene::Scene BlockScene() {
  scene::Scene out;
  out.name = "block";
  out.landmarks["occlusal_centre"] = {0, 0, 0};
  return out;
}

scene::Exercise BlockExercise() {
  scene::Exercise out;
  out.name = "box";
  out.target.half_size_um = {1500, 1200, 0};
  out.target.depth_um = 2000;
  out.target.leeway_side_um = 200;
  out.target.leeway_bottom_um = 100;
  out.target.container_um = 500;
  return out;
}

core::CoreParams SomeParams() {
  core::CoreParams p;
  p.kc_mn_per_mm = 1000;
  p.resolution_nm = {30'000, 30'000, 30'000};
  p.device_origin_nm = {1'000'000, -2'000'000, 3'000'000};
  p.peak_force_mn = 6000;
  p.bur_shape = cutting::BurShape::kCylinder;
  p.bur_radius_nm = 500'000;
  p.bur_length_nm = 4'000'000;
  return p;
}

ProcessRecorder StraightRecording(uint32_t ticks, double speed_mm_per_s, double force_n) {
  ProcessRecorder recorder(SomeParams());
  for (uint32_t i = 0; i < ticks; ++i) {
    trace::Tick tick;
    tick.witness.anchor_100nm[0] =
        static_cast<int32_t>(std::lround(i * speed_mm_per_s * 1e4 / 1000));
    tick.witness.force_computed_mn[2] = static_cast<int32_t>(std::lround(force_n * 1e3));
    recorder.AddRecorded(tick);
  }
  return recorder;
}

Cut::Cut(const Volume& block, const Cavity& cavity)
    : volume(CutCavity(block, cavity)),
      mesh(surface::ExtractSurface(volume)),
      process(StraightRecording(200, 1, 1)) {}

double ValueOf(const MetricSet& metrics, std::string_view name) {
  for (const MetricValue& m : metrics.values) {
    if (m.name == name) return m.value;
  }
  ADD_FAILURE() << name << " has no value";
  return std::nan("");
}

}  // namespace enamel::scoring
