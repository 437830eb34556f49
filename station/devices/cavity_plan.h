#pragma once

#include <array>
#include <string>
#include <variant>
#include <vector>

#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "common/math/vec.h"

// What a simulated dentist intends to do to cut a box-shaped cavity: strokes of the bur's tip in
// the scene frame (m; +z out of the tooth, +x mesial, +y buccal).
namespace enamel::station {

// A box to cut: its top is open.
struct BoxCut {
  dvec3 centre_m{0};  // middle of the box's opening: the landmark
  // Walls, relative to the centre: distal (-x), mesial (+x), lingual (-y), buccal (+y).
  double distal_m = 0, mesial_m = 0, lingual_m = 0, buccal_m = 0;  // all positive, outward
  double depth_m = 0;
};

// A line of moves with the same intent. The bur stops at every corner.
struct Stroke {
  std::vector<dvec3> points;  // from where the last stroke ended, to each of these
  double feed_m_per_s = 0;    // never faster
  double push_n = 0;          // about how hard along the way, at most
  double tolerance_m = 1e-4;  // a corner is reached when the bur is this near
  bool bur_on = true;
};

// A ring of strokes repeated with growing depth across it until the bur was seen where it should
// be on every side: how a wall or floor is finished. The operator remembers per side how much he
// has to lean, and stops leaning on a side that is done.
struct FinishRing {
  std::vector<dvec3> corners;  // closed: the last joins the first
  std::vector<dvec3> outward;  // per side i (corner i to i + 1): unit, into the material
  double feed_m_per_s = 0;
  double push_n = 0;
  bool gentle = false;        // little left and all sides share it: lean more in small steps
  double tolerance_m = 1e-4;  // a corner is reached when the bur is this near
  double accuracy_m = 4e-6;   // a side is done where its depth was seen within this
  int max_passes = 9;
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

// Whether the bur goes into the box with room for the stock on both sides.
bool FitsInto(const BoxCut& box, const cutting::Bur& bur, const CavityPlanOptions& options);

// The plan for cutting `box` into `volume` with `bur`, upright. Layers in open air are left out.
// Requires: FitsInto.
std::vector<Move> PlanCavity(const BoxCut& box, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options);

// Highest solid point over a rectangle in x and y, scene z in m; the grid's bottom if there is
// none.
double HighestSolid_m(const cutting::Volume& volume, double x0, double x1, double y0, double y1);

}  // namespace enamel::station
