#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace enamel::mesh {

// One triangle's use of an edge.
struct EdgeUse {
  uint32_t low, high;  // vertices, low < high
  uint32_t triangle;
  bool forward;  // the triangle runs from low to high
  bool SameEdge(const EdgeUse& o) const { return low == o.low && high == o.high; }
};

// All uses of all edges, those of one edge next to each other, in ascending order.
// Requires: no triangle names a vertex twice.
std::vector<EdgeUse> SortedEdges(std::span<const std::array<uint32_t, 3>> triangles);

// Calls visit(uses of one edge) for each edge.
template <typename Visit>
void ForEachEdge(const std::vector<EdgeUse>& sorted, Visit visit) {
  for (size_t first = 0; first < sorted.size();) {
    size_t last = first + 1;
    while (last < sorted.size() && sorted[last].SameEdge(sorted[first])) ++last;
    visit(std::span<const EdgeUse>(sorted).subspan(first, last - first));
    first = last;
  }
}

}  // namespace enamel::mesh
