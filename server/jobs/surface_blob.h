#pragma once

#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/surface/surface.h"
#include "common/timeline/deviation.h"

// A surface as the page reads it: format "ENTM", version 1 (schemas/api/openapi.yaml,
// /attempts/{id}/surface). Deterministic. Thread safety: functions, any thread.
namespace enamel::server {

// A tooth's surface, and the cell of the grid that each vertex was made in.
struct CelledSurface {
  surface::Mesh mesh;
  std::vector<ivec3> cell;
};
CelledSurface CelledSurfaceOf(const cutting::Volume& volume);

// Positions in 1/65535 of the longest side of the surface's box, normals in 1/127. Requires: fewer
// than 2^32 vertices and triangles.
Bytes EncodeSurface(const surface::Mesh& mesh);
// With a deviation, in mm; NaN where its cells have none. The volume and the stored deviation
// give the same bytes again.
Bytes EncodeSurface(const CelledSurface& surface, const timeline::Deviation& deviation);

}  // namespace enamel::server
