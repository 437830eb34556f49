#pragma once

#include <array>
#include <span>
#include <vector>

namespace enamel::station::lab {

// How fast an error falls with the voxel size. An error has a sign and depends on where the grid
// lies, so it may cross zero at one voxel size and have no order there. Its RMS over grids that lie
// differently has one.
struct ObservedOrder {
  double order = 0;          // log2 of the RMS at twice the voxel over that at the voxel
  double low = 0, high = 0;  // 95 % of bootstrap samples of the grids (Efron, 1979)
};
double Rms(std::span<const double> errors);
// Errors at voxels that differ by a factor of two, one for each grid. The same sample every time.
// Requires: neither is empty.
// `paired`: sample i is the same case in both, and is drawn in both or in neither.
ObservedOrder OrderOf(std::span<const double> coarse, std::span<const double> fine,
                      bool paired = false);

// Where an error of this order still counts as falling. A smaller order is a floor.
inline constexpr double kFalls = 0.9;

// Roache's Grid Convergence Index (J. Fluids Eng. 116, 1994, 405) of values at 8h, 4h, 2h and h, for
// a value without a closed form. Its order is that of the last two halvings.
struct GridConvergence {
  double order = 0;
  double index = 0;  // 1.25 |change of the last halving| / (2^order - 1), in the value's unit
  // Whether the first halving falls by that order too, within a quarter, and all three changes have
  // one sign. Else the index means nothing: order and index are not numbers.
  bool asymptotic = false;
};
GridConvergence IndexOf(const std::array<double, 4>& coarse_to_fine);

}  // namespace enamel::station::lab
