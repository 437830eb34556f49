#pragma once

#include <utility>
#include <vector>

#include "common/cutting/profile.h"
#include "station/lab/cutting/tick_cost.h"

namespace enamel::station::lab {

// What a bur removes and feels on a path of tick_cost.h, from its outline alone: the reference that
// cutting is compared with. Block's frame. Where the path goes is where the bur's tip was, not the
// hand: tissue pushes a slanting face sideways, and the coupling's spring gives way by 0.2 um.
//  * Groove, along +x, the bur's axis from outside the block to X: width 2 r(z) at height z, so the
//    volume is the integral over the depth of 2 r X + pi r^2 / 2. For a ball it is the ball's sweep.
//  * Plunge, along the axis: pi R(z)^2 over the depth, R being the largest radius at or below z.
//  * Force: F = -beta v times the integral of n (n . d) over the front (cutting/engagement.h).
// Integrals over the outline by the midpoint rule, 4000 steps: good to 1e-6 of the result.
class SweptBody {
 public:
  // `tips_m`: the bur's tip in every tick, in the block's frame.
  SweptBody(const CutPath& path, std::vector<dvec3> tips_m);

  double Volume_m3() const;
  // From the surface of the hole, positive outside it.
  double Distance_m(const dvec3& point_m) const;
  // On the hand, while the bur travels at the path's speed with its whole front in the block.
  dvec3 Force_n() const;

 private:
  bool plunge_;
  double speed_m_s_, beta_;
  cutting::Bur bur_;
  cutting::Profile profile_;
  std::vector<dvec3> tips_m_;
  std::vector<double> half_area_m2_, hole_m3_;  // up to a height: of r, and of pi R^2
  double step_m_;
};

}  // namespace enamel::station::lab
