#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/scoring/mistakes/fault_volumes.h"

// Points of a cut: what each region's measures cost. A region pays its dearest measure, once; a cut
// costs the sum over its regions, and the score is 100 less that. Every measure only grows with its
// set of voxels and every price only grows with its measure, so a larger or a further fault never
// earns points. Where one voxel holds something left and something taken too far, the voxel has their difference.
//
// A price of a measure M is  p M / sqrt(1 + (M / s)^2):  p points where M is 1 and small against s,
// p s points at most, and no corner between.
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

struct PriceCurve {
  double points = 0;     // p
  double saturates = 1;  // s

  double At(double measure) const;
};

struct RegionPrice {
  // M is 1 at these sizes. What was taken cannot be mended, so that over_m is at most left_m.
  double over_m = 0, left_m = 0;
  PriceCurve price;
};

struct Prices {
  std::array<RegionPrice, kRegionKinds> regions;  // by RegionKind
  PriceCurve elsewhere;                           // of mm^3 taken where R is not near
  PriceCurve neighbour;                           // of mm, as deep over 1 mm^2
  PriceCurve pulp;                                // of mm^3
  PriceCurve caries;                              // of the share left
};
// Chosen, as is every figure in it: no source gives the points of a size.
Prices ChosenPrices();

enum class Measure : uint8_t { kOver, kLeft, kNotDone, kElsewhere, kNeighbour, kPulp, kCaries };

// A measure with its points: of a region, or of the attempt where `region` is -1.
struct RegionCost {
  int region = -1;  // of AcceptableCut::regions(); -1: none
  Measure measure = Measure::kOver;
  // mm as an even layer, with the leeway; a share where not done or caries; mm^3 elsewhere and of the
  // pulp.
  double size = 0;
  double points = 0;
};

struct CutCost {
  std::vector<RegionCost> rows;  // those above 0, regions in their order
  double sum = 0;                // of them
  double score() const { return sum < 100 ? 100 - sum : 0; }
};

CutCost CostOf(const AcceptableCut& r, const FaultVolumes& faults, const Prices& prices);

}  // namespace enamel::scoring
