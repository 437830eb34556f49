#pragma once

#include <random>

#include "common/mesh/triangles.h"

namespace enamel::import {

// A crown made by a formula of rings, with size, form and wear by chance: what no template of the
// product was made from. Occlusal at +z, buccal at +y, closed below by a dome; millimetres.
struct MadeTooth {
  mesh::Triangles mesh;
  int tooth = 0;  // FDI number
};
MadeTooth MakeTooth(int tooth, std::mt19937& random);

// Without what lies below `share` of its height along `up`, on a plane that leans by chance.
mesh::Triangles CutOpen(const mesh::Triangles& mesh, const dvec3& up, double share,
                        std::mt19937& random);
// Reduced evenly by `depth_mm` above `share` of its height along `up`, as for a crown.
mesh::Triangles ReducedAbove(const mesh::Triangles& mesh, const dvec3& up, double share,
                             double depth_mm);
// With a box in the middle of its occlusal side.
mesh::Triangles WithCavity(const mesh::Triangles& mesh, const dvec3& up, double radius_mm,
                           double depth_mm);
mesh::Triangles TurnedBy(const mesh::Triangles& mesh, const dmat3& turn);
// The 24 turns that take axes to axes.
std::vector<dmat3> QuarterTurns();

}  // namespace enamel::import
