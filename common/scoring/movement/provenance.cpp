#include "common/scoring/movement/provenance.h"

#include <algorithm>
#include <bit>

namespace enamel::scoring {
namespace {

using cutting::kBrickVoxels;
using cutting::Volume;

constexpr uint32_t kStands = UINT32_MAX;

}  // namespace

std::optional<uint32_t> Provenance::TickOf(const ivec3& voxel) const {
  if (voxel.x < 0 || voxel.y < 0 || voxel.z < 0) return {};
  const ivec3 at = voxel / cutting::kBrickSide;
  if (!spec.Contains(at)) return {};
  auto brick = std::lower_bound(bricks.begin(), bricks.end(), spec.BrickIndex(at),
                                [](const Brick& b, int index) { return b.index < index; });
  if (brick == bricks.end() || brick->index != spec.BrickIndex(at)) return {};
  const int i = (voxel.z % 8 * 8 + voxel.y % 8) * 8 + voxel.x % 8;
  const auto word = static_cast<size_t>(i / 64);
  if ((brick->gone[word] >> (i % 64) & 1) == 0) return {};
  size_t rank = brick->first;
  for (size_t w = 0; w < word; ++w) rank += static_cast<size_t>(std::popcount(brick->gone[w]));
  const uint64_t before = brick->gone[word] & ((uint64_t{1} << (i % 64)) - 1);
  return tick[rank + static_cast<size_t>(std::popcount(before))];
}

ProvenanceRecorder::ProvenanceRecorder(const Volume& initial)
    : initial_(initial), slot_(static_cast<size_t>(initial.spec().brick_count()), -1) {}

ProvenanceRecorder::Noted& ProvenanceRecorder::Open(int32_t brick) {
  slot_[static_cast<size_t>(brick)] = static_cast<int32_t>(noted_.size());
  Noted& noted = noted_.emplace_back();
  noted.tick.fill(kStands);
  if (initial_.IsStored(brick)) {
    const auto& phi = initial_.Phi(brick).phi;
    for (size_t i = 0; i < phi.size(); ++i) noted.solid[i] = static_cast<int16_t>(phi[i] >> 15);
  } else {
    noted.solid.fill(initial_.UniformTissue(brick) == cutting::Tissue::kAir ? 0 : -1);
  }
  return noted;
}

void ProvenanceRecorder::Add(const Volume& volume, std::span<const int32_t> touched) {
  const auto now = static_cast<uint32_t>(std::min<uint64_t>(ticks_++, kStands - 1));
  for (int32_t brick : touched) {
    if (!volume.IsStored(brick)) continue;
    const int32_t slot = slot_[static_cast<size_t>(brick)];
    if (slot < 0 && noted_.size() == Provenance::kMaxBricks) {
      complete_ = false;
      continue;
    }
    Noted& noted = slot < 0 ? Open(brick) : noted_[static_cast<size_t>(slot)];
    const int16_t* phi = volume.Phi(brick).phi.data();
    // Layer by layer of 64: a cut moves most distances of a brick and turns few of them to air, so
    // that one test without a branch in it, which compilers do eight samples at a time, spares
    // most of the work.
    for (int from = 0; from < kBrickVoxels; from += 64) {
      int16_t* solid = noted.solid.data() + from;
      int16_t turned = 0;
      for (int i = 0; i < 64; ++i) {
        turned = static_cast<int16_t>(turned | ((phi[from + i] >> 15) ^ solid[i]));
      }
      if (turned == 0) continue;
      for (int i = 0; i < 64; ++i) {
        if (phi[from + i] < 0 || solid[i] == 0) continue;
        solid[i] = 0;
        noted.tick[static_cast<size_t>(from + i)] = now;
      }
    }
  }
}

Provenance ProvenanceRecorder::Take() const {
  Provenance out;
  out.spec = initial_.spec();
  out.ticks = ticks_;
  out.complete = complete_;
  for (size_t b = 0; b < slot_.size(); ++b) {
    if (slot_[b] < 0) continue;
    const Noted& noted = noted_[static_cast<size_t>(slot_[b])];
    Provenance::Brick brick{static_cast<int32_t>(b), static_cast<uint32_t>(out.tick.size()), {}};
    for (size_t i = 0; i < noted.tick.size(); ++i) {
      if (noted.tick[i] == kStands) continue;
      brick.gone[i / 64] |= uint64_t{1} << (i % 64);
      out.tick.push_back(noted.tick[i]);
    }
    if (out.tick.size() > brick.first) out.bricks.push_back(brick);
  }
  return out;
}

}  // namespace enamel::scoring
