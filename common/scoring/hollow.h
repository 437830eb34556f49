#pragma once

#include "common/cutting/volume.h"
#include "common/surface/surface.h"

namespace enamel::scoring {

// Distance of points of a tooth from the solid that a preparation takes, where a volume gives the
// prepared tooth. Deterministic. Thread safety: const after construction.
class Hollow {
 public:
  // Both are kept, not copied. Requires: equal grids.
  Hollow(const cutting::Volume& initial, const cutting::Volume& prepared);

  // m, to the surface that the preparation leaves; negative in what has to go. At most `limit_m`
  // either way. Requires: a point that is solid in `initial`.
  double Distance_m(const dvec3& point_m, double limit_m) const;
  // The same without side, of any point.
  double ToCut_m(const dvec3& point_m, double limit_m) const {
    return cut_.Distance_m(point_m, limit_m);
  }

 private:
  const cutting::Volume& prepared_;
  const surface::DistanceQuery cut_;
};

}  // namespace enamel::scoring
