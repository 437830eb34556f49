#pragma once

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"

// Wanted shapes as geometry: what has to go, and the tooth or block with exactly that gone.
namespace enamel::scene {

// Signed distance (m) to the hollow, negative inside it: the union of its parts. A part is an
// upright prism that begins at its opening and goes on upward without end. Exact outside one part
// and on its faces. Requires: at least one part.
double PreparationDistance_m(const Preparation& preparation, const dvec3& point_m);

// The volume after a perfect preparation: phi := max(phi, -distance), as a bur would leave it that
// can reach every corner. A reference to compare a cut with. Bricks left without solid become air.
cutting::Volume Prepared(const cutting::Volume& volume, const Preparation& preparation);

// The box that just holds a preparation, as an exercise's target with the same landmark (the
// preparation's name). Requires: at least one part.
CavityTarget BoundingTarget(const Preparation& preparation);

}  // namespace enamel::scene
