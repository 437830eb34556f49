#pragma once

#include "common/math/vec.h"
#include "common/scene/builder.h"

// A lower right first molar (FDI 46) as an implicit body of our own: five cusps on a barrel-shaped
// crown, two roots, enamel cap, dentin, pulp chamber with horns and canals. Proportions follow
// textbook averages: crown 11 x 10 x 7.5 mm, roots 14 mm, enamel 2 to 2.5 mm at the cusps and 0 at
// the cervical line.
namespace enamel::scene {

// Scene frame (types.h), metres. A pure function of the point. Thread safety: any thread.
FieldSample MolarField(const dvec3& point_m);

// Box that holds the whole tooth, roots included, metres.
struct MolarBox {
  dvec3 lo_m, hi_m;
};
MolarBox MolarBounds();

// Bottom of the central fossa, on the surface, metres.
dvec3 MolarCentralFossa();

}  // namespace enamel::scene
