#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

// One triangle by its corners, for cutting it up.
struct Facet {
  dvec3 a, b, c;

  static Facet Of(const Triangles& mesh, const std::array<uint32_t, 3>& t) {
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  }
  dvec3 Middle() const { return (a + b + c) / 3.0; }
  dvec3 AreaNormal() const { return 0.5 * glm::cross(b - a, c - a); }
  // Radius of the smallest sphere around its middle.
  double Radius() const {
    const dvec3 m = Middle();
    return std::sqrt(std::max({Dot(a - m, a - m), Dot(b - m, b - m), Dot(c - m, c - m)}));
  }
  // Cut across its longest edge, which makes slivers shorter, not only smaller.
  std::array<Facet, 2> Halves() const {
    const double ab = Dot(b - a, b - a), bc = Dot(c - b, c - b), ca = Dot(a - c, a - c);
    if (bc > ab && bc >= ca) return Facet{b, c, a}.Halves();
    if (ca > ab) return Facet{c, a, b}.Halves();
    const dvec3 m = 0.5 * (a + b);
    return {Facet{a, m, c}, Facet{m, b, c}};
  }
};

}  // namespace enamel::mesh
