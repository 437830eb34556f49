#pragma once

#include <array>
#include <string>
#include <variant>
#include <vector>

#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "common/math/vec.h"
#include "station/devices/outline.h"

// A simulated dentist's plan to cut a cavity: strokes of the bur's tip in the scene frame (m;
// common/scene/types.h).
namespace enamel::station {

// An upright hollow to cut, open at the top.
struct HollowCut {
  Outline walls;
  double floor_m = 0;  // height
};

// A line of moves with the same intent. The bur stops at every corner.
struct Stroke {
  std::vector<dvec3> points;  // from where the last stroke ended, to each of these
  double feed_m_per_s = 0;    // never faster
  double push_n = 0;          // about how hard along the way, at most
  double tolerance_m = 1e-4;  // a corner is reached when the bur is this near
  bool bur_on = true;
};

// A ring of strokes that finishes a wall or floor: repeated with growing depth until the bur was
// seen in place on every side. The operator remembers for each side how far to lean, and stops
// leaning on a side that is done.
struct FinishRing {
  std::vector<dvec3> corners;  // closed: the last joins the first
  std::vector<dvec3> outward;  // per side i (corner i to i + 1): unit, into the material
  double feed_m_per_s = 0;
  double push_n = 0;
  bool gentle = false;        // little left and all sides share it: lean more in small steps
  double tolerance_m = 1e-4;  // a corner is reached when the bur is this near
  double accuracy_m = 4e-6;   // a side is done where its depth was seen within this
  int max_passes = 12;
};

using Move = std::variant<Stroke, FinishRing>;

struct CavityPlanOptions {
  double wall_stock_m = 0.25e-3;  // left by roughing
  double floor_stock_m = 0.15e-3;
  double layer_m = 0.55e-3;  // depth of a roughing layer
  double rough_push_n = 2.2;
  double finish_push_n = 1.4;
  double speed_ratio = 1;  // of all feeds
  bool clockwise = false;  // direction of the rings
};

// A ring along an outline's sides that pushes away from its middle (outward 1) or towards it (-1).
FinishRing RingAlong(const Outline& outline, double z_m, bool clockwise, double outward);

// A ring whose corners are set, as one that finishes downward.
void SetUpFloor(FinishRing& ring);

// Stock that roughing leaves on the walls: less where the bur has little room.
double WallStock_m(const HollowCut& hollow, const cutting::Bur& bur,
                   const CavityPlanOptions& options);

// Whether the bur fits between the walls with stock on all sides, and the hollow below `top_m` is
// deeper than the stock on its floor.
bool FitsInto(const HollowCut& hollow, double top_m, const cutting::Bur& bur,
              const CavityPlanOptions& options);

// The plan for cutting `hollow` into `volume` with `bur`, upright. Layers in open air are left out.
// Requires: FitsInto, convex walls.
std::vector<Move> PlanCavity(const HollowCut& hollow, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options);

// A part of a target, in the scene, and the error of the hand that cuts it.
struct PartCut {
  scene::PreparationPart part;
  // How far beyond the part each wall, floor, table and foot is cut.
  std::function<double(const glm::dvec2& outward)> deeper_m;
  double lower_m = 0;
};
// Cuts all around a stump and its top, down to its foot: layer by layer from above, outermost round
// first, clear of the neighbours in the volume.
std::vector<Move> PlanStump(const PartCut& cut, const cutting::Bur& bur,
                            const cutting::Volume& volume, const CavityPlanOptions& options);

// Highest solid point over a rectangle in x and y, scene z in m; the grid's bottom if there is
// none.
double HighestSolid_m(const cutting::Volume& volume, const Bounds& over);

}  // namespace enamel::station
