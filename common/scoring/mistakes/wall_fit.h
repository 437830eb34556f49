#pragma once

#include <vector>

#include "common/scoring/mistakes/acceptable_cut.h"

// How one region is off: moved or leaning as a whole, in waves, or only in a part of it. Private to mistakes.cpp and
// naming.cpp.
// Thread safety: functions, any thread.
namespace enamel::scoring {

struct RegionFit {
  // d = moved + lean (z - middle), over all of the region, mm and degrees. + over.
  double moved_mm = 0, lean_deg = 0;
  // The median of d over its area: what most of it moved by, whatever its rim and corners did.
  double median_mm = 0;
  double half_height_mm = 0;  // from the middle to its ends, as far as pieces reach
  // Of d by height, averaged over the width, what the formula explains, 0 to 1. A wall that leans has 1, whether or not
  // it does so by its whole width; a step at half its height 0.875.
  double explained = 0;
  int rows = 0;  // of so many heights 0.2 mm apart
  // Of its area, width and height: what moved by a third of the typical amount, 0 to 1, on the side that moved more.
  double of_area = 0, of_width = 0, of_height = 0;
  double at_height = 0;  // the middle of that part, 0 at the foot to 1 at the rim
};
// `off_mm`: by piece, + over.
RegionFit FitRegion(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm);

// A wave goes up and down twice at the least, in one wall or along all regions of another kind: floors, cusps, a margin.
bool IsWavy(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm);

}  // namespace enamel::scoring
