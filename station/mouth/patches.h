#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "station/render/mesher.h"

namespace enamel::station::mouth {

// Squares of surfaces.
inline constexpr double kSquare_mm = 0.3;

// A surface over the plane, sampled on squares, as pieces that can be culled one by one. `vertex`: of
// a corner (i, j), 0 to nx and 0 to ny; `hidden`: whether the square from that corner is left out.
template <typename Vertex, typename Hidden>
std::vector<render::GroupMesh> Patches(int nx, int ny, Vertex&& vertex, Hidden&& hidden) {
  constexpr int kPiece = 24;
  std::vector<render::GroupMesh> out;
  for (int i0 = 0; i0 < nx; i0 += kPiece) {
    for (int j0 = 0; j0 < ny; j0 += kPiece) {
      const int i1 = std::min(i0 + kPiece, nx), j1 = std::min(j0 + kPiece, ny), row = j1 - j0 + 1;
      render::GroupMesh mesh;
      for (int i = i0; i <= i1; ++i) {
        for (int j = j0; j <= j1; ++j) mesh.vertices.push_back(vertex(i, j));
      }
      for (int i = i0; i < i1; ++i) {
        for (int j = j0; j < j1; ++j) {
          if (hidden(i, j)) continue;
          const auto a = static_cast<uint32_t>((i - i0) * row + j - j0),
                     b = a + static_cast<uint32_t>(row);
          mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
        }
      }
      if (!mesh.indices.empty()) out.push_back(std::move(mesh));
    }
  }
  return out;
}

// A vertex of a surface with this slope along x and y.
inline render::GpuVertex VertexAt(const dvec3& p_mm, double dz_dx, double dz_dy, uint8_t material) {
  const dvec3 n = glm::normalize(dvec3(-dz_dx, -dz_dy, 1));
  auto byte = [](double v) { return static_cast<int8_t>(std::lround(127 * v)); };
  return {{static_cast<float>(p_mm.x), static_cast<float>(p_mm.y), static_cast<float>(p_mm.z)},
          {byte(n.x), byte(n.y), byte(n.z)},
          material};
}

}  // namespace enamel::station::mouth
