#pragma once

#include "common/base/result.h"
#include "common/mesh/triangle_tree.h"
#include "common/mesh/triangles.h"

namespace enamel::mesh {

// The pieces of a closed mesh that have solid on one side and none on the other, all facing away
// from it. Inside is what the mesh surrounds at least once, whichever way around
// (TriangleTree::Inside).
struct SolidBoundary {
  Triangles pieces;     // over the mesh's vertices, then those of cut triangles
  size_t crossing = 0;  // triangles that others cross or lie upon
  size_t buried = 0;    // triangles left out as a whole
};

// Only a line along which triangles cross parts one side of a mesh from another, so each patch
// between such lines is judged by one of its triangles; triangles on a line are halved down to
// `finest_mm` (coarser where that would be over a million pieces) and judged piece by piece. Parts
// that nothing crosses are judged whole. Errors: kInvalidInput when triangles overlap everywhere (a
// soup: on average more than 40 crossings or 400 overlapping boxes each; or more than half of over
// 2000 triangles cross others). Requires: closed parts, no triangle that names a vertex twice;
// `tree` holds the same mesh, millimetres.
Result<SolidBoundary> BoundaryOf(const Triangles& mesh, const TriangleTree& tree,
                                 double finest_mm = 0.01);

}  // namespace enamel::mesh
