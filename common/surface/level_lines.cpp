#include "common/surface/level_lines.h"

#include <algorithm>

#include "common/base/check.h"

namespace enamel::surface {

std::vector<LineSegment> ZeroLines(const Mesh& mesh, std::span<const float> values) {
  ENAMEL_CHECK(values.size() == mesh.position_m.size());
  std::vector<LineSegment> out;
  for (const auto& t : mesh.triangles) {
    LineSegment segment;
    int found = 0;
    for (size_t k = 0; k < 3; ++k) {
      // The same way in both triangles of an edge, so that their ends meet to the bit.
      const uint32_t a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      if ((values[a] < 0) == (values[b] < 0)) continue;
      const float share = values[a] / (values[a] - values[b]);
      const glm::vec3 p = mesh.position_m[a] + share * (mesh.position_m[b] - mesh.position_m[a]);
      (found++ == 0 ? segment.from_m : segment.to_m) = p;
    }
    if (found == 2) out.push_back(segment);
  }
  return out;
}

}  // namespace enamel::surface
