#pragma once

#include <span>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/surface/surface.h"
#include "common/timeline/deviation.h"

namespace enamel::server {

// A surface as the page reads it: format "ENTM", version 1 (schemas/api/openapi.yaml,
// /attempts/{id}/surface). Positions in 1/65535 of the longest side of the surface's box, normals
// in 1/127. `deviation_m` (metres; NaN where untouched) is empty or one per vertex, and written in
// mm. Deterministic. Thread safety: a function, any thread. Requires: fewer than 2^32 vertices and
// triangles.
Bytes EncodeSurface(const surface::Mesh& mesh, std::span<const float> deviation_m = {});

// The deviation in such a surface by the cells of the grid that it was made from; encoded
// (EncodeDeviation) it has a hundredth of the bytes. Errors: kNotFound when it has no deviation;
// kInvalidInput when it is no surface. Thread safety: a function, any thread.
Result<timeline::Deviation> DeviationOfSurface(ByteView surface, const cutting::GridSpec& spec);

}  // namespace enamel::server
