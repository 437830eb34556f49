#pragma once

#include <functional>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"

// Wanted shapes as geometry: what has to go, and the tooth or block with exactly that gone.
namespace enamel::scene {

// How far a hollow is grown: its walls outward (those of a stump inward) and its floor down.
struct Growth {
  double side_m = 0, bottom_m = 0;
};

// Signed distance (m) to the hollow, negative inside it: the union of its parts. A part is an
// upright prism that begins at its opening and has no upper end. The distance is exact on its faces
// and outside one part, with three exceptions: edges of grown polygons are round; a stump's sloped
// walls are met to second order in the slope; and for a relief it is the distance to the plane that
// touches it above or below the point. A relief is grown straight down. Only + - * / sqrt, so equal
// on every machine. Requires: at least one part.
double PreparationDistance_m(const Preparation& preparation, const dvec3& point_m,
                             const Growth& grown = {});

// How many times nearer its surface may be than PreparationDistance_m returns: 1, or 2 with a
// relief whose slopes are no steeper than 60 degrees.
double DistanceErrs(const Preparation& preparation);

// Height (m) of a point over the relief of a part, across it: negative in what stays.
// Requires: the part has a relief.
double HeightOverRelief_m(const PreparationPart& part, const dvec3& point_m);
// The relief's own height in the scene (m), and how it rises along x and y.
struct ReliefPoint {
  double z_m = 0, rise_x = 0, rise_y = 0;
};
ReliefPoint ReliefAt(const PreparationPart& part, double x_m, double y_m);

// The landmark that a target hangs from. Errors: kInvalidInput when the scene does not have it.
Result<PointUm> TargetPoint(const Scene& scene, const CavityTarget& target);

// The shape of a target in the scene: its parts, or its box. Named as the landmark. Errors:
// TargetPoint's.
Result<Preparation> TargetShape(const Scene& scene, const CavityTarget& target);

// Spared: voxels of a neighbouring tooth do not change.
enum class Neighbours { kCut, kSpared };
// phi := max(phi, -distance), as a bur would leave it that can reach every corner. Bricks left
// without solid become air. `distance_m` of a point of the scene is negative in what goes; the
// surface may be at most `errs` times nearer than it says.
cutting::Volume CutAway(const cutting::Volume& volume,
                        const std::function<double(const dvec3& point_m)>& distance_m, double errs,
                        Neighbours neighbours);
// The volume after a perfect preparation, to compare a cut with.
cutting::Volume Prepared(const cutting::Volume& volume, const Preparation& preparation,
                         Neighbours neighbours = Neighbours::kCut);

// A preparation as an exercise's target with the same landmark (the preparation's name, where its
// first part opens): its parts, and the box that just holds them. A single box has no parts: the
// target's own box says it. Requires: at least one part.
CavityTarget TargetFor(const Preparation& preparation);

// The box about `target`'s landmark holds every part.
bool HoldsItsParts(const CavityTarget& target);

}  // namespace enamel::scene
