#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scoring/deviation.h"
#include "common/scoring/planes.h"
#include "common/scoring/zones.h"

// The shape of a cut against the reference's. Statistics are taken over the reference's cut
// surface, its walls and floor, and its outline on the tooth: the reference fixes them, never the
// attempt. So nothing that is cut or left elsewhere can dilute a figure. Deterministic. Thread
// safety: functions, any thread.
namespace enamel::scoring {

// One side of a comparison.
struct CutSide {
  const cutting::Volume* volume = nullptr;
  const surface::Mesh* mesh = nullptr;            // of volume
  const std::vector<bool>* cut = nullptr;         // CutVertices of mesh
  const std::vector<double>* areas_m2 = nullptr;  // VertexAreas_m2 of mesh
};

// Distances over the reference's cut surface to the attempt's surface.
struct DeviationFigures {
  double rms_m = 0, p95_m = 0;
  // Share of the area that is no farther off than each band.
  static constexpr std::array<double, 4> kBands_m = {0.1e-3, 0.2e-3, 0.3e-3, 0.5e-3};
  std::array<double, 4> within{};
  double most_left_m = 0;  // least of 0.02 mm^2 of it where the attempt left most
};
// `deviation_m`: DeviationPerVertex of the reference's mesh against the attempt (so + is left).
DeviationFigures MeasureDeviation(const CutSide& reference, const std::vector<float>& deviation_m);

// How deep at least 0.02 mm^2 of the attempt's surface is under the reference's, and where it is
// deepest. `deviation_m`: of the attempt's mesh against the reference (so + is too deep).
struct Deepest {
  double depth_m = 0;
  dvec3 at_m{0};
};
Deepest DeepestOver(const CutSide& attempt, const std::vector<float>& deviation_m);

// The plane normal . p = reach.
struct Facet {
  dvec3 normal{0, 0, 1};  // unit, out of the solid
  double reach_m = 0;
};

// How far the attempt lies over the reference along a wall, + deeper: a plane, and waves about it.
struct Sheet {
  dvec3 normal{0, 0, 1}, up{1, 0, 0}, along{0, 1, 0};
  Plane plane;                         // s: metres along `up`; t: along `along`
  double s_least_m = 0, s_most_m = 0;  // as far as the wall goes
  double waves_m = 0;                  // root mean square, of gouges only as much as of a wave

  // Held constant beyond the wall's foot and rim.
  double At_m(const dvec3& point_m) const;
  // In the middle of the wall's length.
  double AtHeight_m(double s_m) const { return plane.At({0, 0, s_m, plane.t0}); }
};

// One wall or the floor. Heights d of the attempt's surface over the reference's are taken along
// the reference wall's mean normal, + where the attempt goes deeper, at the reference's vertices. A
// plane d = a + b s + c t is fitted to them by least squares, weighted by area, between 15 and 90 %
// of the wall's height: below is the bur's radius, above the rim. s runs up the wall (along +x on a
// floor), t along it. Heights more than four median residuals off the plane belong to another face
// or a gouge; the plane leaves them out.
struct WallFigures {
  bool in_task = false;  // the reference has 0.05 mm^2 and a tenth of the face
  bool begun = false;    // of 30 % of the area what stands before it is cut, or gone
  bool made = false;  // the attempt has cut a surface there: along 70 % of the area a line meets it
  double offset_m = 0;  // median of d; of nearest distances where no line meets the surface
  // atan b, degrees; of a floor the steepest direction, without sign. + opens towards the top, - is
  // undercut, both against the reference's wall.
  double tilt_deg = 0;
  double opens_deg = 0;   // the attempt's wall against +z: the reference's own and tilt_deg
  double waviness_m = 0;  // RMS of d about the plane
  Facet facet;            // of the attempt's surface, fitted in the same way
  Sheet over;             // of d
};
using Walls = std::array<WallFigures, kPartCount>;
Walls MeasureWalls(const cutting::Volume& initial, const CutSide& attempt, const CutSide& reference,
                   const std::vector<float>& reference_deviation_m, const OpenBox& target,
                   double depth_m);

// Where the cut meets the tooth's surface: the middles of the edges between a vertex that was cut
// and one that was not. From each point of the reference's outline to the nearest of the
// attempt's; over where the attempt has cut at the reference's point, short where it has not.
std::vector<dvec3> OutlineOf(const CutSide& side);
struct OutlineFigures {
  bool in_task = false;  // the reference has one
  double over_m = 0;     // 95 % of the outline goes no farther out
  double short_m = 0;    // 95 % of it stays back no farther
  // Of the reference's outline, where the attempt went farther.
  struct Over {
    dvec3 at_m;
    double by_m;
  };
  std::vector<Over> over_at;
  size_t points = 0;  // of all the reference's
};
OutlineFigures MeasureOutline(const cutting::Volume& initial, const CutSide& attempt,
                              const CutSide& reference);

// The pulp's own surface, known to half a voxel; empty where there is none.
surface::Mesh PulpSurface(const cutting::Volume& initial);

// Least distance from the attempt's cut surface to pulp that is still covered, and the vertex it is
// least at; 0 where pulp is open. Known to half a voxel, as labels are whole voxels. At most
// `limit_m`, then without a vertex.
struct RemainingDentin {
  double least_m = 0;
  std::optional<size_t> vertex;
};
RemainingDentin MeasureRemainingDentin(const cutting::Volume& initial, const CutSide& attempt,
                                       double limit_m);

}  // namespace enamel::scoring
