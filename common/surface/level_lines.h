#pragma once

#include <span>
#include <vector>

#include "common/surface/surface.h"

namespace enamel::surface {

struct LineSegment {
  glm::vec3 from_m{0}, to_m{0};
};

// Where a field that is given at a mesh's vertices is zero, linear along the edges: one segment for
// each triangle that it crosses, in the triangles' order. Closed loops on a closed mesh.
// Requires: one value for each vertex; none is NaN. Thread safety: a function, any thread.
std::vector<LineSegment> ZeroLines(const Mesh& mesh, std::span<const float> values);

}  // namespace enamel::surface
