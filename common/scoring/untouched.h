#pragma once

#include <array>

#include "common/cutting/volume.h"
#include "common/scoring/zones.h"

// Measures what an attempt left as it was, a side or the top of the task, and what it left of a stump.
// Formulas: schemas/score.md. Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// The task's volume by the four sides of its box, divided along the diagonals as seen from above:
// +x, -x, +y, -y. Shares of each that went, 0..1; 1 where a side has less than a tenth of the task.
// Requires: equal grids.
std::array<double, 4> SidesDone(const cutting::Volume& initial, const cutting::Volume& attempt,
                                const cutting::Volume& reference, const OpenBox& target);

// The stump of a crown's reference: what stands above `bottom_z_m` under its top. The top is what faces
// up above the middle between that height and its highest point, neighbours apart.
struct StumpFigures {
  // Height that went over it, summed, as a share of what the reference took there; more than 1 where
  // more went, 1 where it took nothing.
  double top_done = 1;
  double top_asked_m = 0;  // height that the reference took there, mean
  double left = 1;         // share of its height that still stands, summed likewise; 0..1
};
// Requires: equal grids.
StumpFigures MeasureStump(const cutting::Volume& initial, const cutting::Volume& attempt,
                          const cutting::Volume& reference, const OpenBox& target,
                          double bottom_z_m);

}  // namespace enamel::scoring
