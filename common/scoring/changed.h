#pragma once

#include <vector>

#include "common/cutting/volume.h"

// Where a tooth differs at all from how it was. A cut touches a few bricks of many; what is asked
// of the others is answered by this alone, with the same bits.
// Deterministic. Thread safety: const after construction.
namespace enamel::scoring {

class ChangedBricks {
 public:
  // Compares every brick's samples. Requires: equal grids.
  ChangedBricks(const cutting::Volume& initial, const cutting::Volume& after);

  bool Brick(int brick) const { return brick_[static_cast<size_t>(brick)]; }
  // False only where interpolation at the point reads no sample that changed: there the two
  // volumes' distances are equal. True outside the grid.
  bool MayDifferAt(const dvec3& point_m) const;

 private:
  const cutting::GridSpec spec_;
  std::vector<bool> brick_;
  // Cells that begin in the brick read a sample that changed, there or in the next one up.
  std::vector<bool> cells_;
};

}  // namespace enamel::scoring
