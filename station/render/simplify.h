#pragma once

#include "station/render/mesher.h"

namespace enamel::station::render {

// Reduces triangles without visible change: merges equal vertices, and collapses edges while the
// surface moves by no more than `error_mm` (quadric error, meshoptimizer's). The outer border does
// not change, so neighbouring groups still meet; normals stay the volume's. Also unchanged:
// triangles between two tissues (colours would smear), and those along edges and grooves (light
// would), with the borders around them. Thread safety: pure.
void Simplify(GroupMesh& mesh, float error_mm);

// Reduces further, for a moving picture: fills `coarse`, with the same vertices, and changes the
// surface itself only by merging equal vertices. Same border, so that coarse and exact groups meet.
// Call it before Simplify, whose large triangles would hide edges.
void Coarsen(GroupMesh& mesh, float error_mm);

}  // namespace enamel::station::render
