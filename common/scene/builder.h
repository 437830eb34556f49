#pragma once

#include <array>
#include <functional>
#include <memory>
#include <utility>

#include "common/cutting/volume.h"

namespace enamel::scene {

// One sample of a tooth to be: signed distance to its outer surface (m, negative inside) and the
// tissue there. Within 4 voxels of the surface the distance must be good to a fraction of a voxel;
// beyond, it may be anything of the right sign that does not exceed the true distance, so that
// whole bricks can be skipped by one sample at their middle. Outside the solid the tissue is that
// of the nearest solid where the field knows it; kAir there is filled in by the builder, so that
// labels of stored bricks are never air and a voxel's removal is always booked to a tissue.
struct FieldSample {
  double distance_m;
  cutting::Tissue tissue;
  // No other tissue is nearer than this; 0: not known. Lets deep bricks of one tissue be skipped.
  double tissue_margin_m = 0;
};

using Field = std::function<FieldSample(const dvec3& point_m)>;

// Samples a field into a volume: bricks without a surface or tissue boundary become one word. May
// use any libm: the result is stored as a blob and never rebuilt elsewhere. The result does not
// depend on `threads` as long as the field is a function of the point. Points are visited brick by
// brick, x fastest. `progress` (0..1, from one of the threads) may be empty. Requires:
// ValidateGrid(spec).ok(). Thread safety: `field` is called from `threads` at once.
cutting::Volume BuildVolume(const cutting::GridSpec& spec, const Field& field, int threads = 1,
                            const std::function<void(double)>& progress = {});
// A field that computes whole bricks: for fields that are costly far from the surface, or that save
// work on samples next to each other. Magnitudes above `reach_m` may be cut off there.
class BrickField {
 public:
  using Samples = std::array<FieldSample, cutting::kBrickVoxels>;  // (z, y, x), x fastest
  virtual ~BrickField() = default;
  virtual FieldSample At(const dvec3& point_m, double reach_m) = 0;
  // Samples at corner + voxel * (x, y, z), to the values that At gives.
  virtual void Brick(const dvec3& corner_m, double voxel_m, double reach_m, Samples& out) = 0;
};
// The same for such fields: each thread makes one of its own (`make_field` is called in it).
cutting::Volume BuildVolume(const cutting::GridSpec& spec,
                            const std::function<std::unique_ptr<BrickField>()>& make_field,
                            int threads, const std::function<void(double)>& progress);

// The smallest grid whose samples cover lo..hi (m) with a band of 5 voxels around.
cutting::GridSpec GridAround(const dvec3& lo_m, const dvec3& hi_m, int32_t voxel_nm);

// Gives brick `brick` of `to` what it is in `from`. Requires: equal grids; the brick of `to` is
// air.
void CopyBrick(const cutting::Volume& from, int brick, cutting::Volume& to);

// Cores to build with: what the machine has, at most 8.
int BuildThreads();

}  // namespace enamel::scene
