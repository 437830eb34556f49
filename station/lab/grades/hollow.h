#pragma once

#include <array>
#include <functional>
#include <optional>

#include "common/cutting/volume.h"
#include "common/scene/preparation.h"

// The volume to remove from a tooth, in closed form, and the tooth without it. No bur is involved,
// so its measures are known in advance. Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

// Distance (m) of a point of the scene to the volume to remove, negative inside it. Near its
// surface accurate to a fraction of a voxel; it changes by at most twice the distance moved.
using Hollow = std::function<double(const dvec3& point_m)>;

double NothingTaken(const dvec3& point_m);
double EverythingTaken(const dvec3& point_m);

// Signed distance to an axis-aligned box, exact.
double BoxDistance_m(const dvec3& point_m, const dvec3& lo_m, const dvec3& hi_m);

// The union.
Hollow Both(Hollow a, Hollow b);
// Turned about +z through the origin, by `degrees`.
Hollow Turned(Hollow hollow, double degrees);

// One face of a cavity. `moved_m` outwards; positive `slope` opens a wall towards the top, about
// the middle of its height (a floor: deeper towards +x, about its middle); `wave_m` is the height
// of three waves along the wall.
struct Face {
  double moved_m = 0, slope = 0, wave_m = 0;
};

// A cavity between five faces, open at the top. `centre_m` is the middle of its opening; faces in
// the order of scoring::Part: mesial, distal, buccal (+y), lingual, floor.
struct BoxCavity {
  dvec3 centre_m{0};
  double half_x_m = 0, half_y_m = 0, depth_m = 0;
  std::array<Face, 5> faces{};
  int mesial_x = 1;  // scene::MesialX

  double Distance_m(const dvec3& point_m) const;
};

// Cut all round a stump down to a shoulder. The stump is a rectangle with rounded corners whose
// half sizes and middle change evenly from the shoulder to its flat top.
struct CrownCut {
  struct Section {
    double middle_x_m = 0, middle_y_m = 0, half_x_m = 0, half_y_m = 0;
  };
  double shoulder_z_m = 0, top_z_m = 0;
  Section at_shoulder, at_top;
  double corner_m = 0;  // radius
  double wave_m = 0;    // height of four waves of the shoulder around the stump
  // For a top that is a relief instead of flat: the part that has it, in the scene, and how far
  // below it the top is. top_z_m is then only the height of at_top.
  std::optional<scene::PreparationPart> table;
  double table_lower_m = 0;

  // The stump's walls farther in by `in_m`, its top lower by `lower_m`.
  CrownCut Moved(double in_m, double lower_m) const;
  // The shoulder lower by `lower_m`, with the walls extended.
  CrownCut Deeper(double lower_m) const;
  // The same foot with its mesial and distal walls at `degrees` to each other; or (degrees < 0) the
  // same top and a foot narrower from mesial to distal; or the top moved mesially, so that the
  // stump leans by `degrees`.
  CrownCut Converging(double degrees) const;
  CrownCut Undercut(double degrees) const;
  CrownCut Leaning(double degrees) const;
  // The top is wider than 0.4 mm in both directions: the walls do not meet below it.
  bool HasTop() const;
  // Lean of the middle line between the mesial and the distal wall, degrees.
  double Lean_deg() const;
  // Height over the top, as if it were unlimited.
  double OverTop_m(const dvec3& point_m) const;
  double Distance_m(const dvec3& point_m) const;
};
Hollow Cut(const CrownCut& as);
// An exercise's target as a stump.
CrownCut CrownCutOf(const scene::PreparationPart& part);

using scene::Neighbours;
cutting::Volume CutAway(const cutting::Volume& initial, const Hollow& hollow,
                        Neighbours neighbours = Neighbours::kCut);

// Volume of the tooth (m^3) at points that `counts` accepts, by 27 points to a voxel: a second way
// to measure a removal. Considers only voxels within `lo_m`..`hi_m` and, if given, in `within`.
double VolumeWhere_m3(const cutting::Volume& initial, const dvec3& lo_m, const dvec3& hi_m,
                      const std::function<bool(const dvec3&, cutting::Tissue)>& counts,
                      const Hollow& within = {});

// A block of 7 x 6 x 4 mm, its top at z = 0, of enamel, dentin and pulp in layers that end at -1.2
// and -3.2 mm. Caries in a ball under the floor of the cavity; a neighbour of 1 mm beyond a gap of
// 0.2 mm at its mesial side.
struct BlockGrid {
  int32_t voxel_nm = 100'000;
  double shift_m = 0;  // of the whole grid
};
inline constexpr double kBlockCaries_m = 0.6e-3;  // radius of the ball
dvec3 BlockCariesMiddle_m();
inline constexpr double kBlockNeighbour_m = 3.7e-3;  // x at which it begins
cutting::Volume FaultBlock(const BlockGrid& grid);
// The cavity of its exercise: 3 x 2.4 mm and 2 mm deep.
BoxCavity FaultBlockCavity();

}  // namespace enamel::station::lab
