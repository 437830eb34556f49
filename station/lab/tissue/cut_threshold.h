#pragma once

#include <vector>

#include "station/lab/tissue/cut_windows.h"

namespace enamel::station::lab::cut {

// Finds Fth: the gate whose motion, computed from the force, is nearest to the measured motion.
// `longer`: windows of `width`, long enough for the few counts of slow motion; a magnitude, which
// has no direction to add up over turns, uses the windows of the fit of B. Needs SmoothForce; fills
// in fit->threshold_n and threshold_seen. `basis`, `values`: B, as for FrontSpeed. Pure function,
// any thread.
void FitThreshold(const Recording& r, const std::vector<Window>& windows,
                  const std::vector<Window>& longer, double width, const dmat3& basis,
                  const dvec3& values, double c, CutFit* fit);

}  // namespace enamel::station::lab::cut
