#include "common/surface/brick_block.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/base/state_hash.h"

namespace enamel::surface {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

// -1 solid throughout, +1 air throughout, 0 stored.
int SignOf(const Volume& volume, const ivec3& b) {
  if (!volume.spec().Contains(b)) return 1;
  int brick = volume.spec().BrickIndex(b);
  if (volume.IsStored(brick)) return 0;
  return volume.UniformTissue(brick) == Tissue::kAir ? 1 : -1;
}

// A brick and its 26 neighbours, x fastest: samples, or nullptr where `solid` says all.
struct Neighbourhood {
  std::array<const int16_t*, 27> phi;
  std::array<bool, 27> solid;
};

// The three bricks side by side that hold a block's row, and the row's first sample in them.
struct RowSource {
  size_t left, sample;
};
constexpr RowSource SourceOf(int y, int z) {
  // 0 is the neighbour's last layer, 1 to 8 the brick's own, 9 the other neighbour's first.
  int by = (y + kBrickSide - 1) / kBrickSide, bz = (z + kBrickSide - 1) / kBrickSide;
  int iy = (y + kBrickSide - 1) % kBrickSide, iz = (z + kBrickSide - 1) % kBrickSide;
  return {static_cast<size_t>((bz * 3 + by) * 3),
          static_cast<size_t>((iz * kBrickSide + iy) * kBrickSide)};
}

uint32_t RowSides(const Neighbourhood& near, const RowSource& from) {
  const int16_t* left = near.phi[from.left];
  const int16_t* own = near.phi[from.left + 1];
  const int16_t* right = near.phi[from.left + 2];
  uint32_t bits = near.solid[from.left];
  if (left) bits = left[from.sample + kBrickSide - 1] < 0;
  uint32_t middle = !own && near.solid[from.left + 1] ? 0xff : 0;
  if (own) {
    for (int x = 0; x < kBrickSide; ++x) {
      middle |= static_cast<uint32_t>(own[from.sample + static_cast<size_t>(x)] < 0) << x;
    }
  }
  uint32_t last = near.solid[from.left + 2];
  if (right) last = right[from.sample] < 0;
  return bits | middle << 1 | last << (kBrickSide + 1);
}

// Fills `inside`. False when no surface passes: all samples are on one side.
bool FindSides(const Neighbourhood& near, Block& block) {
  constexpr uint32_t kWholeRow = (1u << kSide) - 1;
  uint32_t any = 0, all = kWholeRow;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      uint32_t bits = RowSides(near, SourceOf(y, z));
      block.inside[static_cast<size_t>(z * kSide + y)] = bits;
      any |= bits;
      all &= bits;
    }
  }
  return any != 0 && all != kWholeRow;
}

int16_t UniformPhi(bool solid) { return static_cast<int16_t>(solid ? -kPhiLimit : kPhiLimit); }

void CopySamples(const Neighbourhood& near, Block& block) {
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      RowSource from = SourceOf(y, z);
      const int16_t* left = near.phi[from.left];
      const int16_t* own = near.phi[from.left + 1];
      const int16_t* right = near.phi[from.left + 2];
      int16_t* row = &block.phi[SampleIndex(0, y, z)];
      row[0] = left ? left[from.sample + kBrickSide - 1] : UniformPhi(near.solid[from.left]);
      if (own) {
        std::memcpy(row + 1, own + from.sample, kBrickSide * sizeof(int16_t));
      } else {
        std::fill_n(row + 1, kBrickSide, UniformPhi(near.solid[from.left + 1]));
      }
      row[kBrickSide + 1] = right ? right[from.sample] : UniformPhi(near.solid[from.left + 2]);
    }
  }
}

// Corners of crossed cells, per row as Block::inside.
std::array<uint32_t, kSide * kSide> CornersOfCrossedCells(const Block& block) {
  std::array<uint32_t, kSide * kSide> corners{};
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      uint32_t a = block.Row(y, z), b = block.Row(y + 1, z), c = block.Row(y, z + 1),
               d = block.Row(y + 1, z + 1);
      uint32_t any = a | b | c | d, all = a & b & c & d;
      uint32_t crossed = (any | any >> 1) & ~(all & all >> 1) & ((1u << kCells) - 1);
      uint32_t both = crossed | crossed << 1;
      for (int i = 0; i < 4; ++i) {
        corners[static_cast<size_t>((z + i / 2) * kSide + y + i % 2)] |= both;
      }
    }
  }
  return corners;
}

}  // namespace

// False when no surface passes near the brick; the block's samples are then not filled.
bool Gather(const Volume& volume, int brick, Block& block) {
  const GridSpec& spec = volume.spec();
  block.brick = ivec3(brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
                      brick / (spec.bricks.x * spec.bricks.y));
  block.first = block.brick * kBrickSide - 1;
  Neighbourhood near;
  bool stored = false;
  int solid = 0;
  for (int i = 0; i < 27; ++i) {
    auto n = static_cast<size_t>(i);
    ivec3 b = block.brick + ivec3(i % 3, i / 3 % 3, i / 9) - 1;
    int sign = SignOf(volume, b);
    near.phi[n] = sign == 0 ? volume.Phi(spec.BrickIndex(b)).phi.data() : nullptr;
    near.solid[n] = sign < 0;
    stored |= sign == 0;
    solid += sign < 0;
  }
  if (!stored && (solid == 0 || solid == 27)) return false;
  if (!FindSides(near, block)) return false;
  CopySamples(near, block);
  return true;
}

uint64_t Fingerprint(const Block& block) {
  StateHash hash;
  std::array<uint32_t, kSide* kSide> corners = CornersOfCrossedCells(block);
  for (size_t row = 0; row < corners.size(); ++row) {
    if (corners[row] == 0) continue;
    // Where the row is, which of its samples count, and their sides.
    hash.U64(row << 40 | uint64_t{corners[row]} << 20 | block.inside[row]);
    for (uint32_t left = corners[row]; left != 0; left &= left - 1) {
      auto x = static_cast<size_t>(std::countr_zero(left));
      hash.U64(static_cast<uint16_t>(block.phi[row * kSide + x]));
    }
  }
  return hash.value() == kNoSurface ? 1 : hash.value();
}

}  // namespace enamel::surface
