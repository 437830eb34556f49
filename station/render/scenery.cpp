#include "station/render/scenery.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::render {

namespace {

template <typename Visit>
void ForEachMesh(const Scenery& scenery, Visit&& visit) {
  for (const GroupMesh& mesh : scenery.fixed) visit(mesh);
  for (const GroupMesh& mesh : scenery.giving_way) visit(mesh);
  for (const GroupMesh& mesh : scenery.opposite) visit(mesh);
}

}  // namespace

size_t Scenery::triangle_count() const {
  size_t out = 0;
  ForEachMesh(*this, [&](const GroupMesh& mesh) { out += mesh.indices.size() / 3; });
  return out;
}

size_t Scenery::bytes() const {
  size_t out = 0;
  ForEachMesh(*this, [&](const GroupMesh& mesh) {
    out += mesh.vertices.size() * sizeof(GpuVertex) +
           (mesh.indices.size() + mesh.coarse.size()) * sizeof(uint32_t);
  });
  return out;
}

std::vector<Box> BoxesOf(std::span<const GroupMesh> meshes) {
  std::vector<Box> out;
  for (const GroupMesh& mesh : meshes) {
    Box& box = out.emplace_back(Box{glm::vec3(1e30f), glm::vec3(-1e30f)});
    for (const GpuVertex& v : mesh.vertices) {
      const glm::vec3 p(v.position_mm[0], v.position_mm[1], v.position_mm[2]);
      box.lo_mm = glm::min(box.lo_mm, p);
      box.hi_mm = glm::max(box.hi_mm, p);
    }
  }
  return out;
}

// By slabs: the share of the way that is between each pair of faces.
bool Covers(const Box& box, const glm::vec3& point_mm, const glm::vec3& eye_mm) {
  float from = 0, to = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const float way = eye_mm[axis] - point_mm[axis];
    const float lo = box.lo_mm[axis] - point_mm[axis], hi = box.hi_mm[axis] - point_mm[axis];
    if (std::fabs(way) < 1e-6f) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    from = std::max(from, std::min(lo / way, hi / way));
    to = std::min(to, std::max(lo / way, hi / way));
  }
  return from < to;
}

}  // namespace enamel::station::render
