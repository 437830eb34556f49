#pragma once

#include <string>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

struct Box {
  dvec3 lo, hi;
  dvec3 size() const { return hi - lo; }
  double extent() const { return glm::max(size().x, glm::max(size().y, size().z)); }
};
// The box of the vertices that the triangles use. Requires: at least one.
Box BoxOf(const Triangles& mesh);

// Millimetres in one mm, um, cm, m, inch. Errors: kInvalidInput, field "unit".
Result<double> UnitInMm(const std::string& name);

// Is this a tooth, of 3 to 40 mm, whose coordinates a mesh file carries finely enough? Files keep
// 24 bits (float), so a tooth far from the origin is coarse: steps over 5 um are refused. Errors:
// kInvalidInput, field "unit"; the message names the units that would fit.
Status CheckSize(const Triangles& mesh_mm, const std::string& unit, double unit_mm);

// "12.35": a number for people.
std::string Fixed(double value, int digits = 2);

}  // namespace enamel::mesh
