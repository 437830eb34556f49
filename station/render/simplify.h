#pragma once

#include "station/render/mesher.h"

namespace enamel::station::render {

// Fewer triangles for the same sight: vertices that are equal become one, and edges are collapsed
// while the surface moves by no more than `error_mm` (quadric error, meshoptimizer's). The outer
// border stays as it is, so that neighbouring groups still meet; normals stay the volume's. Left as
// they are: triangles between two tissues (colours would smear), and those along edges and grooves
// (light would), with the borders around them. Thread safety: pure.
void Simplify(GroupMesh& mesh, float error_mm);

// Fewer still, for a picture that moves: fills `coarse`, of the same vertices, and leaves the surface
// itself as it is but for vertices that are equal. Same border, so that coarse and exact groups
// meet. Comes before Simplify: of large triangles it could not tell edges.
void Coarsen(GroupMesh& mesh, float error_mm);

}  // namespace enamel::station::render
