#pragma once

#include <functional>

#include "common/scene/types.h"

// The floor that is left when a layer is taken off a tooth's surface with an upright bur.
namespace enamel::scene {

// Everything in the scene frame. A point stays when it is deeper than the layer under every point
// of the surface. Above that, the points go that the bur's end can reach from above with its axis
// in the region.
struct Layer {
  // Height (m) of the surface over a point (m). Asked at whole lattice steps from the middle.
  std::function<double(double x_m, double y_m)> surface_m;
  double thick_m = 0;
  double end_radius_m = 0;  // of the bur's end
  bool round_end = false;   // a ball; else flat
  // The axis stays in this rectangle about the middle, and where this is true (none: everywhere).
  std::array<double, 2> axis_half_m{};
  std::function<bool(double x_m, double y_m)> axis_may = {};
};

// The floor below the opening of `part`, which is `at` and its top_um, on a grid of `step_um` over
// the part's half size or, of a stump, its foot's; in steps of 10 um. Above the opening is the
// opening.
// Requires: step_um is a multiple of kLatticeUm; the part's depth is set.
inline constexpr int32_t kLatticeUm = 125;
Relief ReliefOf(const Layer& layer, const PreparationPart& part, const PointUm& at,
                int32_t step_um);

}  // namespace enamel::scene
