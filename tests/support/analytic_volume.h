#pragma once

#include <array>
#include <functional>

#include "common/cutting/volume.h"

// Volumes directly from a closed-form signed distance, one tissue: references that share no code
// with the builder of common/scene.
namespace enamel::test {

inline cutting::Volume VolumeOf(const cutting::GridSpec& spec, cutting::Tissue tissue,
                                const std::function<double(const dvec3&)>& distance_m) {
  using namespace cutting;
  Volume volume(spec);
  double h = spec.voxel_m();
  for (int bz = 0; bz < spec.bricks.z; ++bz)
    for (int by = 0; by < spec.bricks.y; ++by)
      for (int bx = 0; bx < spec.bricks.x; ++bx) {
        std::array<int16_t, kBrickVoxels> phi;
        int low = kPhiLimit, high = -kPhiLimit;
        for (int i = 0; i < kBrickVoxels; ++i) {
          ivec3 v(bx * 8 + (i & 7), by * 8 + ((i >> 3) & 7), bz * 8 + (i >> 6));
          double units = distance_m(spec.origin_m() + dvec3(v) * h) / h * kPhiPerVoxel;
          units = units < -kPhiLimit ? -kPhiLimit : units > kPhiLimit ? kPhiLimit : units;
          phi[i] = static_cast<int16_t>(units < 0 ? units - 0.5 : units + 0.5);
          low = phi[i] < low ? phi[i] : low;
          high = phi[i] > high ? phi[i] : high;
        }
        int brick = spec.BrickIndex(ivec3(bx, by, bz));
        if (low == kPhiLimit) continue;
        if (high == -kPhiLimit)
          volume.SetUniform(brick, tissue);
        else
          volume.SetBrick(brick, phi, {}, tissue);
      }
  return volume;
}

// A block whose top face is z = 0 and that extends to `half_m` sideways and `depth_m` down.
inline cutting::Volume Block(int32_t voxel_nm, double half_m, double depth_m,
                             cutting::Tissue tissue = cutting::Tissue::kEnamel) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  double margin = 1e-3, brick = 8 * spec.voxel_m();
  int across = static_cast<int>((2 * half_m + 2 * margin) / brick) + 1;
  int up = static_cast<int>((depth_m + 2 * margin) / brick) + 1;
  spec.bricks = ivec3(across, across, up);
  auto nm = [](double m) { return static_cast<int64_t>(m * 1e9 + (m < 0 ? -0.5 : 0.5)); };
  spec.origin_nm = {nm(-half_m - margin), nm(-half_m - margin), nm(-depth_m - margin)};
  return VolumeOf(spec, tissue, [=](const dvec3& p) {
    dvec3 q(glm::abs(p.x) - half_m, glm::abs(p.y) - half_m,
            glm::abs(p.z + depth_m / 2) - depth_m / 2);
    double outside = glm::length(glm::max(q, dvec3(0)));
    return outside > 0 ? outside : glm::max(q.x, glm::max(q.y, q.z));
  });
}

}  // namespace enamel::test
