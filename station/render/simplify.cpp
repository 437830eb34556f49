#include "station/render/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/geometric.hpp>
#include <utility>

#include "station/render/revolve.h"

namespace enamel::station::render {
namespace {

// Limits for correct lighting, as cosines.
struct Shading {
  float least_crease;  // between two corners' normals: less is an edge or a groove
  float least_lean;    // of a corner's normal from a large triangle's
  float most_wrong;    // share of the surface where it may lean more
  int most_apart;      // between two corners' looks: more is a border, as of dentin and enamel
  int band;            // of looks that count as one
};
constexpr Shading kAtRest{0.985f, 0.9f, 0.0f, 9, 16};     // 10 and 26 degrees
constexpr Shading kMoving{0.978f, 0.9f, 0.004f, 40, 64};  // 12 and 26 degrees

// Bricks of a group repeat the vertices on the faces between them.
void Weld(GroupMesh& mesh) {
  std::vector<uint32_t> remap(mesh.vertices.size());
  size_t unique =
      meshopt_generateVertexRemap(remap.data(), mesh.indices.data(), mesh.indices.size(),
                                  mesh.vertices.data(), mesh.vertices.size(), sizeof(GpuVertex));
  std::vector<GpuVertex> vertices(unique);
  meshopt_remapVertexBuffer(vertices.data(), mesh.vertices.data(), mesh.vertices.size(),
                            sizeof(GpuVertex), remap.data());
  for (std::vector<uint32_t>* indices : {&mesh.indices, &mesh.coarse}) {
    meshopt_remapIndexBuffer(indices->data(), indices->data(), indices->size(), remap.data());
  }
  mesh.vertices = std::move(vertices);
}

glm::vec3 PositionOf(const GpuVertex& v) {
  return {v.position_mm[0], v.position_mm[1], v.position_mm[2]};
}

glm::vec3 NormalOf(const GpuVertex& v) {
  return glm::normalize(glm::vec3(v.normal[0], v.normal[1], v.normal[2]));
}

// Share of a surface with wrong lighting: triangles that are large and whose corners' normals lean
// away from theirs.
float ShadedWrongly(const std::vector<GpuVertex>& vertices, const std::vector<uint32_t>& indices,
                    float least_lean) {
  constexpr float kLarge_mm = 0.2f;
  float wrong = 0, all = 0;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const GpuVertex* v[] = {&vertices[indices[i]], &vertices[indices[i + 1]],
                            &vertices[indices[i + 2]]};
    glm::vec3 a = PositionOf(*v[0]), b = PositionOf(*v[1]), c = PositionOf(*v[2]);
    float longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    glm::vec3 normal = glm::cross(b - a, c - a);
    float length = glm::length(normal);
    all += length;
    if (longest < kLarge_mm) continue;
    bool leans = std::any_of(std::begin(v), std::end(v), [&](const GpuVertex* corner) {
      return glm::dot(NormalOf(*corner), normal) < least_lean * length;
    });
    if (leans) wrong += length;
  }
  return all > 0 ? wrong / all : 0;
}

// Materials that shade into each other (revolve.h) are one within such a band of shades, so that a
// large triangle's colours are no coarser than that.
constexpr int kBand = 20;
// So do colours of a tooth: within a band of red, and one of blue.
size_t KindOf(const GpuVertex& v, int band) {
  const uint8_t material = v.tissue;
  if (material == kTooth) {
    const auto& [red, green, blue] = v.look.root_albedo;
    return kTooth + static_cast<size_t>(red / band * (256 / band) + blue / band);
  }
  if (material < kGingiva) return material;
  const uint8_t first = material < kRubberDam ? kGingiva : kRubberDam;
  return first + static_cast<size_t>(material - first) / kBand;
}
constexpr size_t kKinds = kTooth + 256;

bool IsBorder(const GpuVertex& a, const GpuVertex& b, const GpuVertex& c, int most_apart) {
  if (a.tissue != kTooth) return false;
  for (size_t i = 0; i < 3; ++i) {
    const auto [lo, hi] =
        std::minmax({a.look.root_albedo[i], b.look.root_albedo[i], c.look.root_albedo[i]});
    if (hi - lo > most_apart) return true;
  }
  return false;
}

// Triangles of one tissue or material without edges, by it; and all others.
struct Parts {
  std::array<std::vector<uint32_t>, kKinds> smooth;
  std::vector<uint32_t> others;
};

Parts Split(const std::vector<GpuVertex>& vertices, const std::vector<uint32_t>& indices,
            const Shading& shading) {
  Parts parts;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const GpuVertex &a = vertices[indices[i]], &b = vertices[indices[i + 1]],
                    &c = vertices[indices[i + 2]];
    glm::vec3 n[] = {NormalOf(a), NormalOf(b), NormalOf(c)};
    float least = std::min({glm::dot(n[0], n[1]), glm::dot(n[1], n[2]), glm::dot(n[2], n[0])});
    const size_t kind = KindOf(a, shading.band);
    bool smooth = kind == KindOf(b, shading.band) && kind == KindOf(c, shading.band) &&
                  !IsBorder(a, b, c, shading.most_apart) && least >= shading.least_crease;
    auto& part = smooth ? parts.smooth[kind] : parts.others;
    part.insert(part.end(), indices.begin() + static_cast<ptrdiff_t>(i),
                indices.begin() + static_cast<ptrdiff_t>(i) + 3);
  }
  return parts;
}

// Fewer triangles of the same vertices.
std::vector<uint32_t> Fewer(const std::vector<GpuVertex>& vertices,
                            const std::vector<uint32_t>& indices, float error_mm,
                            const Shading& shading) {
  const float* positions = vertices[0].position_mm;
  float scale = meshopt_simplifyScale(positions, vertices.size(), sizeof(GpuVertex));
  if (scale <= 0) return indices;
  Parts parts = Split(vertices, indices, shading);
  std::vector<uint32_t> out = std::move(parts.others), fewer;
  for (const std::vector<uint32_t>& part : parts.smooth) {
    if (part.empty()) continue;
    const std::vector<uint32_t>* taken = &part;
    // Less reduction where lighting requires it.
    for (float share : {1.0f, 0.25f, 0.06f}) {
      fewer.resize(part.size());
      fewer.resize(meshopt_simplify(fewer.data(), part.data(), part.size(), positions,
                                    vertices.size(), sizeof(GpuVertex), 0, share * error_mm / scale,
                                    meshopt_SimplifyLockBorder, nullptr));
      if (ShadedWrongly(vertices, fewer, shading.least_lean) > shading.most_wrong) continue;
      taken = &fewer;
      break;
    }
    out.insert(out.end(), taken->begin(), taken->end());
  }
  return out;
}

// Keeps only the used vertices, in their order.
void DropUnused(GroupMesh& mesh) {
  std::vector<uint32_t> all = mesh.indices;
  all.insert(all.end(), mesh.coarse.begin(), mesh.coarse.end());
  std::vector<GpuVertex> vertices(mesh.vertices.size());
  vertices.resize(meshopt_optimizeVertexFetch(vertices.data(), all.data(), all.size(),
                                              mesh.vertices.data(), mesh.vertices.size(),
                                              sizeof(GpuVertex)));
  auto middle = all.begin() + static_cast<ptrdiff_t>(mesh.indices.size());
  mesh.indices.assign(all.begin(), middle);
  mesh.coarse.assign(middle, all.end());
  mesh.vertices = std::move(vertices);
}

void OrderForCache(std::vector<uint32_t>& indices, size_t vertex_count) {
  meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), vertex_count);
}

}  // namespace

void Simplify(GroupMesh& mesh, float error_mm) {
  if (mesh.indices.empty()) return;
  Weld(mesh);
  mesh.indices = Fewer(mesh.vertices, mesh.indices, error_mm, kAtRest);
  OrderForCache(mesh.indices, mesh.vertices.size());
  DropUnused(mesh);
  mesh.bounds = BoundsOf(mesh.vertices, mesh.indices);
}

void Coarsen(GroupMesh& mesh, float error_mm) {
  if (mesh.indices.empty()) return;
  Weld(mesh);
  mesh.coarse = Fewer(mesh.vertices, mesh.indices, error_mm, kMoving);
  OrderForCache(mesh.coarse, mesh.vertices.size());
}

}  // namespace enamel::station::render
