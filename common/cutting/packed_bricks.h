#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/cutting/brick.h"
#include "common/cutting/tissue.h"

namespace enamel::cutting {

// Bricks in about a seventh of their size, each unpacked by itself: what a tooth costs where no bur has been.
//
// Each sample is predicted from those before it, and only the difference is written. Distances change evenly, so inside a
// brick the prediction is a + b + c - ab - ac - bc + abc over the seven neighbours behind (exact for any sum of
// functions of two coordinates; Ibarria et al. 2003, the Lorenzo predictor). On a brick's first planes and lines it is
// an extrapolation of second degree. Beyond the band's limit all samples are alike, and the predicted value continues
// instead, so that a distance that comes back from there is predicted as well. The order of a brick's samples begins at
// the corner where the fewest are at the limit. Differences are written in Rice codes. Their length follows the latest
// differences of the same kind: inside or on an edge, near the limit or not.
//
// Thread safety: const methods from any thread while nobody appends. Real-time: Unpack. Deterministic, but the
// bytes are this build's own: they are stored nowhere.
class PackedBricks {
 public:
  // `labels`: null where all voxels are `tissue`.
  void Append(const BrickPhi& phi, const BrickLabels* labels, Tissue tissue);
  size_t size() const noexcept { return bricks_.size(); }
  Tissue tissue(size_t i) const noexcept { return bricks_[i].tissue; }
  bool has_labels(size_t i) const noexcept { return bricks_[i].has_labels; }
  // The lowest sample.
  int16_t lowest(size_t i) const noexcept { return bricks_[i].lowest; }
  // Exactly what was appended; without labels where the brick has none or `labels` is null.
  // Work: bounded, kBrickVoxels samples (enamel-lab bench memory prints its time).
  ENAMEL_REALTIME void Unpack(size_t i, BrickPhi& phi, BrickLabels* labels) const noexcept;
  size_t MemoryBytes() const noexcept {
    return bytes_.capacity() + bricks_.capacity() * sizeof(Brick);
  }
  // Gives back the room for further bricks.
  void ShrinkToFit();

 private:
  struct Brick {
    uint32_t first;  // of its bytes
    int16_t lowest;
    Tissue tissue;
    bool has_labels;
  };
  std::vector<Brick> bricks_;
  std::vector<uint8_t> bytes_;  // and eight more at the end, so that eight can be read anywhere
};

}  // namespace enamel::cutting
