#pragma once

#include <vector>

#include "station/lab/tissue/cut_windows.h"

namespace enamel::station::lab::cut {

// Fth: where the gate makes the motion computed from the force come nearest to what was measured.
// `longer`: windows of `width`, long enough for the few counts of slow motion; a magnitude has no
// direction to add up over turns and takes the windows B was fitted from.
// Needs SmoothForce; fills in fit->threshold_n and threshold_seen. `basis`, `values`: B, as for
// FrontSpeed. Pure function, any thread.
void FitThreshold(const Recording& r, const std::vector<Window>& windows,
                  const std::vector<Window>& longer, double width, const dmat3& basis,
                  const dvec3& values, double c, CutFit* fit);

}  // namespace enamel::station::lab::cut
