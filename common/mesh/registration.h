#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/triangles.h"

// Where one scan of a tooth is on another scan of the same tooth, which may have been cut in
// between, from any side, with or without its root. Millimetres. Any libm: the result is stored and
// never computed again. Thread safety: functions, any thread.
namespace enamel::mesh {

// p -> rotation p + shift.
struct Rigid {
  dmat3 rotation{1.0};
  dvec3 shift{0};

  dvec3 At(const dvec3& p) const { return rotation * p + shift; }
  Rigid After(const Rigid& first) const {
    return {rotation * first.rotation, rotation * first.shift + shift};
  }
};
// Angle of the turn, degrees.
double TurnOf_deg(const dmat3& rotation);
Triangles Moved(Triangles mesh, const Rigid& by);
// One of kSpiralTurns rotations, spread evenly over all: super-Fibonacci spirals (Alexa, CVPR 2022). Requires:
// i < kSpiralTurns.
inline constexpr size_t kSpiralTurns = 600;
dmat3 SpiralTurn(size_t i);

struct SurfacePoint {
  dvec3 at{0}, normal{0};
};
// `count` points, each for the same area, by a fixed pattern. Requires: triangles with an area.
std::vector<SurfacePoint> SpreadOver(const Triangles& mesh, size_t count);

// Surfaces nearer than this agree: a scanner's error and a model's, and much less than a cut.
inline constexpr double kAgree_mm = 0.15;

// How well a surface fits a closed one. Shares are of the moved surface's area.
struct Fit {
  Rigid fixed_from_moving;
  double agree_share = 0;    // within kAgree_mm, facing the same way
  double inside_share = 0;   // deeper within the solid, or facing another way: it was cut there
  double outside_share = 0;  // farther outside: of the same tooth nothing is
  // Distances of all that is not inside, so of what should agree.
  double rms_mm = 0, p95_mm = 0;
  double cost = 0;                  // 0 all agrees exactly, 1 all is inside, 4 all is outside
  std::vector<double> distance_mm;  // signed, + outside, of points of equal area; within 2 mm
};

// The poses in which `moving` fits the closed mesh `fixed` best, best first, at most ten that
// differ by over half a millimetre somewhere; none where nothing agrees.
//
// 600 even turns (Alexa, CVPR 2022: super-Fibonacci spirals) in seven places each are improved by
// Gauss-Newton steps on a grid of signed distances, slid by up to 1.6 mm each way (a crown reduced
// evenly fits nearly as well where its cut lies on the tooth's surface), then the best on the surface
// itself. Points deep inside have no weight (Tukey's biweight), because they were cut. Points outside
// keep Huber's weight, because nothing grows on a tooth. So neither the cut nor a missing root pulls
// the pose. A pose in which less of the surface agrees, but much more exactly, goes before.
// Point-to-plane steps: Chen and Medioni, Image and Vision Computing 10(3), 1992.
std::vector<Fit> FitOnto(const Triangles& fixed, const Triangles& moving);
// From one pose that is nearly right: within some 0.5 mm and 5 degrees.
Fit FitNear(const Triangles& fixed, const Triangles& moving, const Rigid& start = {});

}  // namespace enamel::mesh
