#pragma once

#include "common/base/bytes.h"
#include "common/surface/surface.h"

namespace enamel::surface {

// A mesh as a binary little-endian PLY file (Turk, "The PLY Polygon File Format", 1994): x y z in
// millimetres, nx ny nz, tissue (uchar, cutting::Tissue), and triangles. Mesh programs and
// `enamel-station import` read it.
Bytes EncodePly(const Mesh& mesh);

}  // namespace enamel::surface
