#pragma once

#include "station/devices/cavity_plan.h"

// How a simulated dentist cuts a floor that follows the tooth: in adjacent rows from mesial to
// distal.
namespace enamel::station {

// Tip position of an upright bur that touches a part's relief from above: a ball at its side, a
// flat end at its rim. Includes what is deeper or farther out of the cut: sideways the relief is
// extended from its middle.
class ReliefTips {
 public:
  // `cut` is kept. Requires: its part has a relief.
  ReliefTips(const PartCut& cut, const cutting::Bur& bur);

  double Height_m(double x_m, double y_m) const;
  double end_radius_m() const { return end_radius_m_; }
  // The part's box. Within it, how far the tip goes along a row before it would have to climb a
  // wall.
  Bounds box() const;
  Bounds ReachAlongX(double y_m) const;
  Bounds ReachAlongY(double x_m) const;

 private:
  template <typename At>
  void Walk(double from, double to, const At& at, double& end) const;
  double Drawn(double offset_m, double half_m, const glm::dvec2& plus) const;

  const PartCut& cut_;
  double end_radius_m_ = 0;
  bool round_end_ = false;
  struct Touch {
    double x = 0, y = 0, z = 0;  // of the bur's end, from its tip
  };
  std::vector<Touch> end_;
};

// Rows over a rectangle, as far as `tips` allows, each from one end to the other, alternating.
// Points are so near that a straight line between them is on the relief.
std::vector<std::vector<dvec3>> RowsOver(const ReliefTips& tips, const Bounds& over,
                                         double spacing_m, double raise_m, bool from_far_side);

// A box whose floor is a relief and whose walls, if any, are lower than the bur is wide.
std::vector<Move> PlanRelief(const PartCut& cut, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options);

}  // namespace enamel::station
