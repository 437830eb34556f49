#pragma once

#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::import {

// Sphere of 2 n x n quads, split; closed, outward. Its volume is the polyhedron's, a little below
// 4/3 pi r^3.
mesh::Triangles SphereMesh(double radius, int n, dvec3 centre = dvec3(0));
// Box lo..hi of 12 triangles.
mesh::Triangles BoxMesh(const dvec3& lo, const dvec3& hi);
// A profile (r, z) turned about z in `around` steps, its left side outward: closed where it begins
// and ends on the axis or where it ends; open otherwise.
struct ProfilePoint {
  double r, z;
};
mesh::Triangles RevolvedMesh(const std::vector<ProfilePoint>& profile, int around,
                             bool closed = false);
// Points of a circle of the given radius around (0, z) from angle `from` to `to` (radians from +z
// toward +r).
std::vector<ProfilePoint> Arc(double radius, double z, double from, double to, int steps);
mesh::Triangles Reversed(mesh::Triangles mesh);
mesh::Triangles Joined(const mesh::Triangles& a, const mesh::Triangles& b);

}  // namespace enamel::import
