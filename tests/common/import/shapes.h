#pragma once

#include "common/import/triangles.h"

namespace enamel::import {

// Sphere of 2 n x n quads, split; closed, outward. Its volume is the polyhedron's, a little below
// 4/3 pi r^3.
Triangles SphereMesh(double radius, int n, dvec3 centre = dvec3(0));
// Box lo..hi of 12 triangles.
Triangles BoxMesh(const dvec3& lo, const dvec3& hi);
Triangles Joined(const Triangles& a, const Triangles& b);

}  // namespace enamel::import
