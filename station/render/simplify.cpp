#include "station/render/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <glm/geometric.hpp>

namespace enamel::station::render {
namespace {

bool HasOneTissue(const GroupMesh& mesh) {
  return std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const GpuVertex& v) { return v.tissue == mesh.vertices.front().tissue; });
}

// Bricks of a group repeat the vertices on the faces between them.
void Weld(GroupMesh& mesh) {
  std::vector<uint32_t> remap(mesh.vertices.size());
  size_t unique =
      meshopt_generateVertexRemap(remap.data(), mesh.indices.data(), mesh.indices.size(),
                                  mesh.vertices.data(), mesh.vertices.size(), sizeof(GpuVertex));
  std::vector<GpuVertex> vertices(unique);
  meshopt_remapVertexBuffer(vertices.data(), mesh.vertices.data(), mesh.vertices.size(),
                            sizeof(GpuVertex), remap.data());
  meshopt_remapIndexBuffer(mesh.indices.data(), mesh.indices.data(), mesh.indices.size(),
                           remap.data());
  mesh.vertices = std::move(vertices);
}

glm::vec3 PositionOf(const GpuVertex& v) {
  return {v.position_mm[0], v.position_mm[1], v.position_mm[2]};
}

// Light would run wrongly over a triangle that is large and whose corners' normals lean away from
// it: beside an edge or in a groove.
bool ShadesAlike(const std::vector<GpuVertex>& vertices, const std::vector<uint32_t>& indices) {
  constexpr float kLarge_mm = 0.2f, kLeastCosine = 0.9f;  // 26 degrees
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const GpuVertex* v[] = {&vertices[indices[i]], &vertices[indices[i + 1]],
                            &vertices[indices[i + 2]]};
    glm::vec3 a = PositionOf(*v[0]), b = PositionOf(*v[1]), c = PositionOf(*v[2]);
    float longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    glm::vec3 normal = glm::cross(b - a, c - a);
    float length = glm::length(normal);
    if (longest < kLarge_mm || length == 0) continue;
    for (const GpuVertex* corner : v) {
      glm::vec3 own(corner->normal[0], corner->normal[1], corner->normal[2]);
      if (glm::dot(own, normal) < kLeastCosine * 127 * length) return false;
    }
  }
  return true;
}

}  // namespace

void Simplify(GroupMesh& mesh, float error_mm) {
  if (mesh.indices.empty() || !HasOneTissue(mesh)) return;
  Weld(mesh);
  const float* positions = mesh.vertices[0].position_mm;
  float scale = meshopt_simplifyScale(positions, mesh.vertices.size(), sizeof(GpuVertex));
  if (scale <= 0) return;
  std::vector<uint32_t> fewer;
  // Less where light asks for it.
  for (float share : {1.0f, 0.25f, 0.06f}) {
    fewer.resize(mesh.indices.size());
    fewer.resize(meshopt_simplify(fewer.data(), mesh.indices.data(), mesh.indices.size(), positions,
                                  mesh.vertices.size(), sizeof(GpuVertex), 0,
                                  share * error_mm / scale, meshopt_SimplifyLockBorder, nullptr));
    if (ShadesAlike(mesh.vertices, fewer)) break;
    fewer.clear();
  }
  if (fewer.empty()) return;
  std::vector<GpuVertex> vertices(mesh.vertices.size());
  vertices.resize(meshopt_optimizeVertexFetch(vertices.data(), fewer.data(), fewer.size(),
                                              mesh.vertices.data(), mesh.vertices.size(),
                                              sizeof(GpuVertex)));
  mesh.vertices = std::move(vertices);
  mesh.indices = std::move(fewer);
  mesh.bounds = BoundsOf(mesh.vertices, mesh.indices);
}

}  // namespace enamel::station::render
