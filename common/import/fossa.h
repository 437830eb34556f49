#pragma once

#include <functional>

#include "common/mesh/triangle_tree.h"

namespace enamel::import {

enum class Centre { kPit, kMiddle, kMaxRoom };
const char* Words(Centre kind);

struct Fossa {
  dvec3 point;
  Centre kind;
};

// The occlusal centre of a tooth in the scene frame, millimetres, where a class I cavity goes: the
// pit nearest the middle of the occlusal surface, else the middle, as far as there is room around
// it for the outline; else the point with most room. `outer` is the tooth's surface, `distance`
// signed (negative inside) to the same, lo..hi the crown's bounding box.
Fossa FindFossa(const mesh::TriangleTree& outer,
                const std::function<double(const dvec3&)>& distance, const dvec3& lo,
                const dvec3& hi);

}  // namespace enamel::import
