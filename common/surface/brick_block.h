#pragma once

#include <array>
#include <cstdint>

#include "common/cutting/volume.h"
#include "common/surface/surface.h"

// One brick's share of the surface, in two steps: gather its samples and those around it, make the
// mesh of them. Shared by surface.h and brick_meshes.h; not for use outside this directory.
namespace enamel::surface {

// A brick's samples with one layer of its neighbours' around them.
inline constexpr int kSide = cutting::kBrickSide + 2;
// Cells that such a block holds whole; cell (0, 0, 0) starts one voxel below the brick.
inline constexpr int kCells = cutting::kBrickSide + 1;
constexpr size_t SampleIndex(int x, int y, int z) {
  return static_cast<size_t>((z * kSide + y) * kSide + x);
}
struct Block {
  ivec3 brick;  // grid coordinates
  ivec3 first;  // voxel of sample (0, 0, 0)
  std::array<int16_t, kSide * kSide * kSide> phi;
  std::array<uint32_t, kSide * kSide> inside;  // per row (z, y): bit x is set where solid

  int At(const ivec3& s) const { return phi[SampleIndex(s.x, s.y, s.z)]; }
  uint32_t Row(int y, int z) const { return inside[static_cast<size_t>(z * kSide + y)]; }
};

// Fills the block. False when no surface passes near the brick; its samples are then not filled.
// Requires: 0 <= brick < brick_count.
bool Gather(const cutting::Volume& volume, int brick, Block& block);

// Over everything that shapes a gathered block's mesh: sides, and samples at corners of crossed
// cells.
uint64_t Fingerprint(const Block& block);
// The value for "no surface here" among fingerprints.
inline constexpr uint64_t kNoSurface = 0;

// The mesh of a gathered block, as ExtractBrick gives it.
Mesh ExtractBlock(const cutting::Volume& volume, const Block& block);

}  // namespace enamel::surface
