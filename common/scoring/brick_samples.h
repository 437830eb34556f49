#pragma once

#include "common/cutting/volume.h"

namespace enamel::scoring {

// Samples of one brick of a volume, whether they are stored or all alike. The volume outlives it.
class BrickSamples {
 public:
  BrickSamples(const cutting::Volume& volume, int brick)
      : phi_(volume.IsStored(brick) ? volume.Phi(brick).phi.data() : nullptr),
        uniform_(volume.UniformTissue(brick) == cutting::Tissue::kAir ? cutting::kPhiLimit
                                                                      : -cutting::kPhiLimit) {}
  // cutting::SolidFraction of sample i of kBrickVoxels.
  int32_t Solid(int i) const { return cutting::SolidFraction(phi_ ? phi_[i] : uniform_); }

 private:
  const int16_t* phi_;
  const int16_t uniform_;
};

}  // namespace enamel::scoring
