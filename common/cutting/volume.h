#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/base/result.h"
#include "common/cutting/brick.h"
#include "common/cutting/brick_store.h"
#include "common/cutting/tissue.h"
#include "common/math/vec.h"

// The tooth: signed distance to the surface and a tissue label per voxel, in sparse bricks.
namespace enamel::cutting {

// Shape of the grid. Voxel (i, j, k) is a sample at origin + voxel * (i, j, k); integers in
// nanometres, so the same blob means the same geometry everywhere.
struct GridSpec {
  int32_t voxel_nm = 0;
  ivec3 bricks{0};                     // bricks along x, y, z
  std::array<int64_t, 3> origin_nm{};  // sample (0, 0, 0), scene frame

  double voxel_m() const noexcept { return voxel_nm * 1e-9; }
  dvec3 origin_m() const noexcept {
    return {static_cast<double>(origin_nm[0]) * 1e-9, static_cast<double>(origin_nm[1]) * 1e-9,
            static_cast<double>(origin_nm[2]) * 1e-9};
  }
  ivec3 voxels() const noexcept { return bricks * kBrickSide; }
  int64_t brick_count() const noexcept {
    return static_cast<int64_t>(bricks.x) * bricks.y * bricks.z;
  }
  int BrickIndex(const ivec3& b) const noexcept { return (b.z * bricks.y + b.y) * bricks.x + b.x; }
  bool Contains(const ivec3& b) const noexcept {
    return b.x >= 0 && b.y >= 0 && b.z >= 0 && b.x < bricks.x && b.y < bricks.y && b.z < bricks.z;
  }
  bool operator==(const GridSpec& o) const {
    return voxel_nm == o.voxel_nm && bricks == o.bricks && origin_nm == o.origin_nm;
  }
};

// Samples of bricks that are one word.
struct UniformPhi {
  std::array<int16_t, kBrickVoxels> air, solid;
  UniformPhi() noexcept;
};
extern const UniformPhi kUniformPhi;

// Sparse volume. Bricks without a surface are one word: air, or deep inside one tissue. A label is
// kept when its voxel turns to air, so that removal can be reported per tissue.
// Thread safety: const methods from any thread while nobody writes. Real-time: all methods below
// "real-time" are safe once Reserve was called; the rest allocate.
class Volume {
 public:
  Volume() = default;
  // All air. Requires: spec validated by ValidateGrid.
  explicit Volume(const GridSpec& spec);

  const GridSpec& spec() const noexcept { return spec_; }

  // --- building and reading (not real-time) ---
  // Makes the brick stored. `labels` empty: all voxels are `tissue`.
  void SetBrick(int brick, std::span<const int16_t, kBrickVoxels> phi,
                std::span<const uint8_t> labels, Tissue tissue);
  void SetUniform(int brick, Tissue tissue);  // kAir, or solid and deep.
  // Room for every uniform solid brick to become stored, so that cutting never allocates; the first
  // kWarmBricks of it are resident.
  void Reserve();
  static constexpr size_t kWarmBricks = 2048;
  size_t MemoryBytes() const noexcept;
  // The lowest sample of a brick.
  int16_t Lowest(int brick) const noexcept;

  // --- real-time ---
  bool IsStored(int brick) const noexcept { return slot_[static_cast<size_t>(brick)] >= 0; }
  // Tissue of a uniform brick (kAir for air), or the label shared by all voxels of a stored one;
  // meaningless where HasLabels.
  Tissue UniformTissue(int brick) const noexcept {
    int32_t s = slot_[static_cast<size_t>(brick)];
    return s >= 0 ? uniform_[static_cast<size_t>(s)] : static_cast<Tissue>(-1 - s);
  }
  bool HasLabels(int brick) const noexcept {
    int32_t s = slot_[static_cast<size_t>(brick)];
    return s >= 0 && label_slot_[static_cast<size_t>(s)] >= 0;
  }
  // A brick's samples, x fastest, also of a uniform one.
  const int16_t* Samples(int brick) const noexcept {
    const int32_t s = slot_[static_cast<size_t>(brick)];
    if (s >= 0) return phi_[static_cast<size_t>(s)].phi.data();
    return s == -1 ? kUniformPhi.air.data() : kUniformPhi.solid.data();
  }
  // Requires: IsStored.
  const BrickPhi& Phi(int brick) const noexcept { return phi_[Slot(brick)]; }
  BrickPhi& MutablePhi(int brick) noexcept { return phi_[Slot(brick)]; }
  // Requires: HasLabels.
  const BrickLabels& Labels(int brick) const noexcept {
    return labels_[static_cast<size_t>(label_slot_[Slot(brick)])];
  }
  // Turns a uniform solid brick into a stored one (all -kPhiLimit). False when the reserve is used up or the brick is
  // air. No effect on a stored brick.
  bool Materialise(int brick) noexcept;
  // Once a tick. Makes one more page of the room resident if less than kWarmBricks are, so that no tick meets many
  // page faults.
  void Warm() noexcept {
    phi_.Warm(kWarmBricks, 1);
    labels_.Warm(kWarmLabels, 1);
  }

  // Distance at a voxel in fixed point; +kPhiLimit outside the grid.
  int PhiAt(const ivec3& voxel) const noexcept;
  Tissue TissueAt(const ivec3& voxel) const noexcept;
  // Trilinear distance at a point of the scene frame, in metres, saturated at about 4 voxels.
  double DistanceAt_m(const dvec3& point_m) const noexcept;
  // Tissue of the nearest voxel.
  Tissue TissueAtPoint(const dvec3& point_m) const noexcept;
  // The same by sample coordinates, (point - origin) / voxel; the distance in voxels.
  double DistanceAtSample(const dvec3& sample) const noexcept;
  // Its change over one voxel along each axis, half a voxel to either side. Trilinear interpolation
  // of a curved wall errs by bumps of one voxel's period, which are the same at both ends. 0 less
  // than two voxels from the grid's edge.
  dvec3 SlopeAtSample(const dvec3& sample) const noexcept;
  // Both at once, in single precision: good to 1e-6 voxels. Samples count as at most kAirBandVoxels
  // away, beyond which a cut knows no distance, so that the result changes by no more than 1 voxel
  // per voxel along each axis. The slope is 0 where the distance is `within` or more.
  double DistanceAndSlope(const dvec3& sample, double within, dvec3& slope) const noexcept;
  Tissue TissueAtSample(const dvec3& sample) const noexcept;
  // A distance that the point surely has, at most 1.6 voxels, from the nearest sample alone: the point is
  // within half a diagonal of it, and a distance changes by no more than the way. 0 where nothing is known.
  // Quick.
  double ClearanceAtSample(const dvec3& sample) const noexcept;

  bool operator==(const Volume& other) const;  // Same grid, same samples, same labels.

 private:
  static constexpr size_t kWarmLabels = 256;
  size_t Slot(int brick) const noexcept {
    const int32_t s = slot_[static_cast<size_t>(brick)];
    ENAMEL_CHECK(s >= 0);
    return static_cast<size_t>(s);
  }
  int SampleIn(int brick, int in_brick) const noexcept { return Samples(brick)[in_brick]; }

  GridSpec spec_;
  // Per brick: an index into phi_ from 0 on, -1 for air, and -1 - t deep inside tissue t.
  std::vector<int32_t> slot_;
  BrickStore<BrickPhi> phi_;
  std::vector<Tissue> uniform_;      // per stored brick
  std::vector<int32_t> label_slot_;  // the same: index into labels_, or -1
  BrickStore<BrickLabels> labels_;
};

// Refuses what cannot be a tooth's grid here: voxel outside 5 um .. 1 mm, empty, or more than
// max_bytes if every brick were stored.
Status ValidateGrid(const GridSpec& spec, size_t max_bytes = size_t{4} << 30);

// Fraction of a voxel that is solid, in 1/65536, from its centre's distance: exact for a plane
// parallel to a face, and right on average for others. Real-time: safe.
inline int32_t SolidFraction(int phi) noexcept {
  // 0.5 - phi / kPhiPerVoxel, clamped to [0, 1].
  int32_t f = 32768 - phi * 8;
  return f < 0 ? 0 : f > 65536 ? 65536 : f;
}

// Solid volume per tissue, m^3.
std::array<double, kTissueCount> SolidVolume_m3(const Volume& volume);

}  // namespace enamel::cutting
