#pragma once

#include <functional>
#include <vector>

#include "common/math/vec.h"

// Distance of a point below a curved floor from it, by points of the floor 0.02 mm apart. (The
// floor's own formula gives the distance of the tangent plane above the point, which is less.)
// Thread safety: const functions, any thread. Not real-time.
namespace enamel::station::lab {

class ReliefDepth {
 public:
  // `over_m`: height over the floor, in proportion to z. The floor is known within `half_m` of
  // `middle_m` in x and y.
  ReliefDepth(const std::function<double(const dvec3&)>& over_m, const dvec3& middle_m,
              double half_m);

  // Height of the floor at a known point.
  double Height_m(double x_m, double y_m) const;
  // Distance of a point below the floor from it, at most `limit_m`; above the floor, minus its
  // height straight over it. Slopes are no steeper than 60 degrees. Requires: x and y at least 2
  // limit_m within half_m.
  double Depth_m(const dvec3& p, double limit_m) const;

 private:
  int Index(double from_lo_m) const;

  double lo_x_m_, lo_y_m_;
  int count_;
  std::vector<double> z_m_;
};

}  // namespace enamel::station::lab
