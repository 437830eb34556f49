#include "common/mesh/mesh_edges.h"

namespace enamel::mesh {

std::vector<EdgeUse> SortedEdges(std::span<const std::array<uint32_t, 3>> triangles) {
  uint32_t vertices = 0;
  for (const auto& t : triangles) vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
  // Counting sort by the lower vertex; its few edges are then put in order.
  std::vector<uint32_t> first(vertices + 1, 0);
  for (const auto& t : triangles) {
    for (size_t k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3]) + 1];
  }
  for (uint32_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
  std::vector<EdgeUse> edges(3 * triangles.size());
  std::vector<uint32_t> next = first;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      edges[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), i, a < b};
    }
  }
  for (uint32_t v = 0; v < vertices; ++v) {
    std::stable_sort(edges.begin() + first[v], edges.begin() + first[v + 1],
                     [](const EdgeUse& l, const EdgeUse& r) { return l.high < r.high; });
  }
  return edges;
}

}  // namespace enamel::mesh
