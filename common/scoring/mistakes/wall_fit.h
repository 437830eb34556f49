#pragma once

#include <vector>

#include "common/scoring/mistakes/acceptable_cut.h"

// How one region is off: moved or leaning as a whole, in waves, or only in a part of it, and how long that is. Private to mistakes.cpp and
// naming.cpp.
// Thread safety: functions, any thread.
namespace enamel::scoring {

struct RegionFit {
  // d = moved + lean (z - middle), over all of the region, mm and degrees. + over.
  double moved_mm = 0, lean_deg = 0;
  // The median of d over its area: what most of it moved by, whatever its rim and corners did.
  double median_mm = 0;
  double half_height_mm = 0;  // from the middle to its ends, as far as pieces reach
  // The formula's share of the squares of d, which is averaged over the width at each height. A wall that leans has 1,
  // whether or not all of its width does; a step at a share f of its height from the rim has f + 3 f (1 - f)^2.
  double explained = 0;
  int rows = 0;  // number of these heights, 0.2 mm apart
  // The part that moved by a third of the typical amount, on the side that moved more, as shares of the region's area,
  // width and height.
  double of_area = 0, of_width = 0, of_height = 0;
  double at_height = 0;  // the middle of that part, 0 at the foot to 1 at the rim
  bool at_end = false;   // that part reaches an end of the region's width: it has no second side
};
// `off_mm`: by piece, + over.
RegionFit FitRegion(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm);

// How many times longer a patch is than wide: the root of the ratio of its two largest second moments, weighted by what it
// moved, |d_mm|. 1 where it has no width.
double LengthOverWidth(const AcceptableCut& r, const std::vector<double>& d_mm,
                       const dvec3& middle_m);

// Whether the surface goes up and down twice at the least: of one wall, or of all regions of another kind together, such as
// a margin's.
bool IsWavy(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm);

}  // namespace enamel::scoring
