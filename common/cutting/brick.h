#pragma once

#include <array>
#include <cstdint>

// One brick of a tooth's samples.
namespace enamel::cutting {

inline constexpr int kBrickSide = 8;  // voxels along a brick's edge
inline constexpr int kBrickVoxels = 512;
// Distance is fixed point: kPhiPerVoxel units are one voxel edge. Negative inside solid. Values
// saturate at +-kPhiLimit, so the band is just under 4 voxels to either side of the surface.
inline constexpr int kPhiPerVoxel = 8192;
inline constexpr int16_t kPhiLimit = 32767;

// One stored brick: (8, 8, 8) samples, x fastest.
struct alignas(64) BrickPhi {
  std::array<int16_t, kBrickVoxels> phi;
};
struct BrickLabels {
  std::array<uint8_t, kBrickVoxels> tissue;
};

}  // namespace enamel::cutting
