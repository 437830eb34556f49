#pragma once

#include "station/render/mesher.h"

namespace enamel::station::render {

// Fewer triangles for the same sight: vertices that are equal become one, and edges are collapsed
// while the surface moves by no more than `error_mm` (quadric error, meshoptimizer's). The outer
// border stays as it is, so that neighbouring groups still meet; normals stay the volume's. Left as
// it is: what has two tissues (colours would smear), and what has edges or grooves (light would). Thread safety: pure.
void Simplify(GroupMesh& mesh, float error_mm);

}  // namespace enamel::station::render
