#pragma once

#include <memory>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::import {

// A way of turning a crown in its file, and how much it then looks like our own tooth of its number.
struct Likeness {
  dmat3 scene_from_file{1.0};  // rows: mesial or distal, buccal, occlusal in the file's frame
  double cost = 0;             // 0: alike
  dvec3 up() const { return {scene_from_file[0][2], scene_from_file[1][2], scene_from_file[2][2]}; }
};

// The best turns, best first, their occlusal directions some 40 degrees apart. The crown is stretched
// to the box of our tooth (built-in forms, stretched to published mean sizes), whole or with a part
// of its height missing, worn or not; compared are distances between the surfaces, both ways.
// `own`: what a scanner saw; `whole`: closed. Millimetres. Requires: an FDI number.
std::vector<Likeness> LikeOwnTooth(const mesh::Triangles& whole, const mesh::Triangles& own,
                                   int tooth);

}  // namespace enamel::import
