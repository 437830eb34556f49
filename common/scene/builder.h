#pragma once

#include <functional>
#include <utility>

#include "common/cutting/volume.h"

namespace enamel::scene {

// One sample of a tooth to be: signed distance to its outer surface (m, negative inside) and the
// tissue there. Outside, the tissue is that of the nearest solid, never air: labels of stored bricks
// are never air, so that a voxel's removal is always booked to a tissue.
struct FieldSample {
  double distance_m;
  cutting::Tissue tissue;
};

// Samples a field into a volume: bricks without a surface or tissue boundary become one word.
// `distance_is_exact` lets whole bricks far from the surface be skipped by one sample at their
// middle. May use any libm: the result is stored as a blob and never rebuilt elsewhere.
// `progress` (0..1) may be empty. Threads: uses `threads` of its own.
cutting::Volume BuildVolume(const cutting::GridSpec& spec,
                            const std::function<FieldSample(const dvec3&)>& field,
                            int threads = 1, const std::function<void(double)>& progress = {});

}  // namespace enamel::scene
