#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"

// When each voxel of an attempt went: found during the replay, kept as a blob
// (schemas/provenance.md), so that a deduction can name strokes and moments.
// A voxel has gone when its centre has turned from solid (distance < 0) to air.
// Deterministic. Thread safety: ProvenanceRecorder has one owner; the rest may be read by any
// thread. Real-time: nothing here is; the station's loop does not know of it.
namespace enamel::scoring {

struct Provenance {
  // More bricks than this are not noted: 16.8 million voxels, 2 cm^3 at 0.05 mm.
  static constexpr size_t kMaxBricks = 32'768;

  // One brick in which something went.
  struct Brick {
    int32_t index = 0;
    uint32_t first = 0;              // of its voxels, in `tick`
    std::array<uint64_t, 8> gone{};  // a bit per sample, in the volume's order

    bool operator==(const Brick&) const = default;
  };

  cutting::GridSpec spec;
  uint64_t ticks = 0;          // of the recording that was looked at
  bool complete = true;        // false: more than kMaxBricks were cut
  std::vector<Brick> bricks;   // by rising index
  std::vector<uint32_t> tick;  // of each voxel that went, brick by brick: the recording's, from 0

  // The tick at which a voxel went; none for one that is still solid, was air before, or is outside
  // the grid.
  std::optional<uint32_t> TickOf(const ivec3& voxel) const;

  // fn(const ivec3& voxel, uint32_t tick), in the order of `tick`.
  template <typename F>
  void ForEach(F&& fn) const;

  bool operator==(const Provenance&) const = default;
};

// Notes moments while the core runs. It reads the bricks that a tick has touched and changes
// nothing.
class ProvenanceRecorder {
 public:
  // `initial`: the tooth before the first tick, of the grid of every volume that follows. It must
  // outlive the recorder.
  explicit ProvenanceRecorder(const cutting::Volume& initial);

  // After each tick, in order: the tooth as it is now, and the bricks that this tick changed
  // (core::Core::touched).
  void Add(const cutting::Volume& volume, std::span<const int32_t> touched);

  // The provenance recorded so far.
  Provenance Take() const;

 private:
  struct Noted {
    std::array<int16_t, cutting::kBrickVoxels> solid;  // -1 solid, 0 not: now
    std::array<uint32_t, cutting::kBrickVoxels> tick;  // kStands where nothing went
  };

  Noted& Open(int32_t brick);

  const cutting::Volume& initial_;
  uint64_t ticks_ = 0;
  bool complete_ = true;
  std::vector<int32_t> slot_;  // per brick: index into noted_, or -1
  std::vector<Noted> noted_;
};

// Equal contents give equal bytes with one version of zstd.
Bytes EncodeProvenance(const Provenance& provenance);
// Bounded. Errors: kVersion for another version; kInvalidInput for everything that schemas/
// provenance.md does not allow.
Result<Provenance> DecodeProvenance(ByteView blob);

template <typename F>
void Provenance::ForEach(F&& fn) const {
  for (const Brick& brick : bricks) {
    const ivec3 corner =
        ivec3(brick.index % spec.bricks.x, brick.index / spec.bricks.x % spec.bricks.y,
              brick.index / spec.bricks.x / spec.bricks.y) *
        cutting::kBrickSide;
    size_t next = brick.first;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      if ((brick.gone[static_cast<size_t>(i / 64)] >> (i % 64) & 1) == 0) continue;
      fn(corner + ivec3(i % 8, i / 8 % 8, i / 64), tick[next++]);
    }
  }
}

}  // namespace enamel::scoring
