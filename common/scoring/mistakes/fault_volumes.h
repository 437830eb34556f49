#pragma once

#include <vector>

#include "common/scoring/mistakes/acceptable_cut.h"

// Compares an attempt with an acceptable cut R: the volume taken beyond R (over) and the volume left within R's hollow
// (left), voxel by voxel, each counted at the nearest piece of R's surface and weighted by the distance from it.
//
// For a region of area A, and each of the two sets, with the distance delta from R's surface and the
// leeway lambda taken off it:
//
//     M^3 = 1/A  integral over the set of  3 ((delta - lambda) / L)^2 / L  dV
//
// where L is the size at which the measure is 1 (prices.h). A layer of even thickness t that begins
// at R's surface has M = (t - lambda) / L. Depth counts more than area, and both count. A film off the untouched surface
// that is thinner than lambda is not over. A larger set never has a smaller M: the integrand depends on R alone, and what
// is a film stops being one when more is taken.
//
// Deterministic. Thread safety: functions, any thread. Not real-time.
namespace enamel::scoring {

// What is taken between these distances of R's surface counts less and less for the region and more
// and more for the part that has nothing to do with R's surface, so that no voxel makes a step.
inline constexpr double kElsewhereFrom_m = 0.6e-3, kElsewhereTo_m = 1.2e-3;

// Over or left at one piece of R's surface.
struct PieceFault {
  double volume_m3 = 0;
  // integral of ((delta - lambda)+)^2 dV, m^5: 3 / (A L^3) of it is M^3.
  double moment_m5 = 0;
};

struct FaultVolumes {
  // By AcceptableCut::pieces(). Without what is counted below.
  std::vector<PieceFault> over, left;
  // How far R's surface moved at each piece, m: + over, - left. Each voxel counts at its nearest piece, even where another
  // piece is charged. At most 1.5 times the distance of the farthest voxel.
  std::vector<double> off_m;
  // Taken from the tooth where nothing of R is near, deeper than the leeway under its untouched surface: at the nearest
  // piece.
  struct Elsewhere {
    double volume_m3 = 0;
    dvec3 moment_m4{0};  // volume times its middle
    // The share of the volume that continues a cut at the piece itself.
    double attached = 0;
  };
  std::vector<Elsewhere> elsewhere;
  double far_m3 = 0;  // and farther than kDeepest_m
  dvec3 far_at_m{0};  // its middle
  // Left of the task in any tissue, farther than the leeway.
  double left_beyond_m3 = 0;
  // Caries of the task, and what was left of it, farther than the leeway; not in `left`.
  double caries_m3 = 0, caries_left_m3 = 0;
  // How much of the shell was left in each row of AcceptableCut::contact; not in `left`.
  std::vector<double> contact_left_m;
  // The integral, over what was taken from a neighbour, of the square of the depth under its surface,
  // which counts to 0.4 mm.
  double neighbour_moment_m5 = 0;
  double pulp_m3 = 0;  // taken from the pulp beyond R, times AcceptableCut::pulp_counts
};

// Requires: grids equal to R's, nothing packed.
FaultVolumes MeasureFaults(const AcceptableCut& r, const cutting::Volume& attempt);

}  // namespace enamel::scoring
