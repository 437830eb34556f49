#pragma once

#include <span>

#include "common/base/bytes.h"
#include "common/surface/surface.h"

namespace enamel::server {

// A surface as the page reads it: format "ENSF", version 1 (schemas/api/openapi.yaml,
// /attempts/{id}/surface). Positions in 1/65535 of the longest side of the surface's box, normals
// in 1/127. `deviation_m` (metres; NaN where untouched) is empty or one per vertex, and written in
// mm. Deterministic. Thread safety: a function, any thread. Requires: fewer than 2^32 vertices and
// triangles.
Bytes EncodeSurface(const surface::Mesh& mesh, std::span<const float> deviation_m = {});

}  // namespace enamel::server
