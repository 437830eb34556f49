#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "common/surface/surface.h"

// Surface of a body as large as a molar with its root: an ellipsoid of 10 x 10 x 20 mm around a
// pulp of 2 x 2 x 8 mm.
namespace enamel::surface {
namespace {

using cutting::Volume;

double Ellipsoid(const dvec3& p, const dvec3& half) {
  // First-order distance: exact near the surface, and only that is stored.
  double k = glm::length(p / half), g = glm::length(p / (half * half));
  return g > 0 ? k * (k - 1) / g : -std::min({half.x, half.y, half.z});
}

Volume Tooth(int32_t voxel_nm) {
  double h = voxel_nm * 1e-9;
  cutting::GridSpec spec{voxel_nm, {}, {-5'200'000, -5'200'000, -10'200'000}};
  auto bricks = [&](double size_m) { return static_cast<int>(size_m / (8 * h)) + 1; };
  spec.bricks = {bricks(10.4e-3), bricks(10.4e-3), bricks(20.4e-3)};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first = ivec3(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                        b / (spec.bricks.x * spec.bricks.y)) *
                  cutting::kBrickSide;
    auto distance = [&](const dvec3& voxel) {
      dvec3 p = spec.origin_m() + voxel * h;
      return std::max(Ellipsoid(p, dvec3(5e-3, 5e-3, 10e-3)),
                      -Ellipsoid(p, dvec3(1e-3, 1e-3, 4e-3))) /
             h;
    };
    double middle = distance(dvec3(first) + 3.5);
    if (std::fabs(middle) > 14) {
      volume.SetUniform(b, middle > 0 ? cutting::Tissue::kAir : cutting::Tissue::kEnamel);
      continue;
    }
    std::array<int16_t, cutting::kBrickVoxels> phi;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      double v = distance(dvec3(first + ivec3(i & 7, i >> 3 & 7, i >> 6))) * cutting::kPhiPerVoxel;
      phi[static_cast<size_t>(i)] = static_cast<int16_t>(
          std::clamp(v, -double{cutting::kPhiLimit}, double{cutting::kPhiLimit}));
    }
    volume.SetBrick(b, phi, {}, cutting::Tissue::kEnamel);
  }
  volume.Reserve();
  return volume;
}

void BM_WholeTooth(benchmark::State& state) {
  Volume volume = Tooth(static_cast<int32_t>(state.range(0)) * 1000);
  size_t triangles = 0;
  for (auto _ : state) triangles = ExtractSurface(volume).triangles.size();
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(BM_WholeTooth)
    ->ArgName("voxel_um")
    ->Arg(100)
    ->Arg(50)
    ->Arg(25)
    ->Unit(benchmark::kMillisecond);

void BM_SurfaceBrick(benchmark::State& state) {
  Volume volume = Tooth(50'000);
  std::vector<int> bricks;
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    if (!ExtractBrick(volume, b).triangles.empty()) bricks.push_back(b);
  }
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(ExtractBrick(volume, bricks[i++ % bricks.size()]));
  state.counters["bricks"] = static_cast<double>(bricks.size());
}
BENCHMARK(BM_SurfaceBrick)->Unit(benchmark::kMicrosecond);

void BM_DistanceQuery(benchmark::State& state) {
  Mesh mesh = ExtractSurface(Tooth(50'000));
  DistanceQuery query(mesh);
  size_t i = 0;
  for (auto _ : state) {
    dvec3 p = dvec3(mesh.position_m[i]) + 0.2e-3 * dvec3(mesh.normal[i]);
    benchmark::DoNotOptimize(query.Distance_m(p, 2e-3));
    i = (i + 997) % mesh.position_m.size();
  }
}
BENCHMARK(BM_DistanceQuery)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace enamel::surface
