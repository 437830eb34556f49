#include "common/timeline/parts.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/surface/surface.h"
#include "common/timeline/samples.h"

namespace enamel::timeline {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;

// The error that meshoptimizer bounds is a mean (quadric) one; that of a place is up to 1.8 times as
// large on a ball of a millimetre (parts_test.cpp).
constexpr double kMeanOfMost = 0.5;

// Meshed between two questions whether to keep going; some milliseconds.
constexpr size_t kBricksBetween = 256;

// A part's triangles before they are fewer.
struct Dense {
  std::vector<PartMesh::Vertex> vertices;
  std::vector<glm::vec3> normals;
  std::vector<uint32_t> indices;
};

std::array<int8_t, 2> Octahedral(const glm::vec3& n) {
  const float sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  if (sum == 0) return {0, 0};
  float x = n.x / sum, y = n.y / sum;
  if (n.z < 0) {
    const float folded = (1 - std::fabs(y)) * (x < 0 ? -1.0f : 1.0f);
    y = (1 - std::fabs(x)) * (y < 0 ? -1.0f : 1.0f);
    x = folded;
  }
  return {static_cast<int8_t>(std::lround(127 * x)), static_cast<int8_t>(std::lround(127 * y))};
}

void Append(const surface::Mesh& mesh, const cutting::GridSpec& spec, Dense& out) {
  const auto first = static_cast<uint32_t>(out.vertices.size());
  const dvec3 origin = spec.origin_m();
  for (size_t v = 0; v < mesh.position_m.size(); ++v) {
    PartMesh::Vertex& vertex = out.vertices.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const double voxels = (double{mesh.position_m[v][axis]} - origin[axis]) / spec.voxel_m() + 1;
      vertex.at[static_cast<size_t>(axis)] =
          static_cast<uint32_t>(std::max(0l, std::lround(voxels * PartMesh::kSteps)));
    }
    vertex.tissue = mesh.tissue[v];
    out.normals.push_back(mesh.normal[v]);
  }
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t corner : triangle) out.indices.push_back(first + corner);
  }
}

// Bricks repeat the vertices on the faces between them.
void Weld(Dense& mesh) {
  if (mesh.indices.empty()) return;
  std::vector<std::array<uint32_t, 3>> places;
  for (const PartMesh::Vertex& vertex : mesh.vertices) places.push_back(vertex.at);
  std::vector<uint32_t> remap(places.size());
  const size_t unique =
      meshopt_generateVertexRemap(remap.data(), mesh.indices.data(), mesh.indices.size(),
                                  places.data(), places.size(), sizeof places[0]);
  std::vector<PartMesh::Vertex> vertices(unique);
  std::vector<glm::vec3> normals(unique);
  for (size_t v = mesh.vertices.size(); v-- > 0;) {
    if (remap[v] == ~0u) continue;
    vertices[remap[v]] = mesh.vertices[v];
    normals[remap[v]] = mesh.normals[v];
  }
  mesh.vertices = std::move(vertices);
  mesh.normals = std::move(normals);
  meshopt_remapIndexBuffer(mesh.indices.data(), mesh.indices.data(), mesh.indices.size(),
                           remap.data());
}

// Voxels.
std::vector<glm::vec3> PlacesOf(const Dense& mesh) {
  std::vector<glm::vec3> out;
  for (const auto& [at, normal, tissue] : mesh.vertices) {
    out.push_back(glm::vec3(at[0], at[1], at[2]) / static_cast<float>(PartMesh::kSteps));
  }
  return out;
}

void AppendFewer(const std::vector<glm::vec3>& places, const std::vector<uint32_t>& indices,
                 double most_voxels, std::vector<uint32_t>& out) {
  if (indices.empty()) return;
  const float* at = &places[0].x;
  const float scale = meshopt_simplifyScale(at, places.size(), sizeof places[0]);
  std::vector<uint32_t> fewer(indices.size());
  fewer.resize(meshopt_simplify(
      fewer.data(), indices.data(), indices.size(), at, places.size(), sizeof places[0], 0,
      static_cast<float>(kMeanOfMost * most_voxels) / scale, meshopt_SimplifyLockBorder, nullptr));
  out.insert(out.end(), fewer.begin(), fewer.end());
}

// In strips, without vertices that no triangle names, and with the volume's normals.
PartMesh Packed(const Dense& mesh, const cutting::Volume& tooth, std::vector<uint32_t> indices) {
  PartMesh out;
  if (indices.empty()) return out;
  meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(),
                                   mesh.vertices.size());
  out.strips.resize(meshopt_stripifyBound(indices.size()));
  out.strips.resize(meshopt_stripify(out.strips.data(), indices.data(), indices.size(),
                                     mesh.vertices.size(), PartMesh::kNewStrip));
  constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> becomes(mesh.vertices.size(), kNone);
  for (uint32_t& vertex : out.strips) {
    if (vertex == PartMesh::kNewStrip) continue;
    uint32_t& place = becomes[vertex];
    if (place == kNone) {
      place = static_cast<uint32_t>(out.vertices.size());
      PartMesh::Vertex& added = out.vertices.emplace_back(mesh.vertices[vertex]);
      const dvec3 sample =
          dvec3(added.at[0], added.at[1], added.at[2]) / double{PartMesh::kSteps} - 1.0;
      added.normal = Octahedral(surface::SmoothNormal(tooth, sample, mesh.normals[vertex]));
    }
    vertex = place;
  }
  return out;
}

PartMesh StillMesh(Dense mesh, const cutting::Volume& volume) {
  Weld(mesh);
  constexpr auto kNeighbour = static_cast<uint8_t>(cutting::Tissue::kNeighbour);
  std::vector<uint32_t> tooth, neighbours, fewer;
  for (auto corner = mesh.indices.begin(); corner != mesh.indices.end(); corner += 3) {
    const bool beside = std::all_of(
        corner, corner + 3, [&](uint32_t v) { return mesh.vertices[v].tissue == kNeighbour; });
    auto& part = beside ? neighbours : tooth;
    part.insert(part.end(), corner, corner + 3);
  }
  const std::vector<glm::vec3> places = PlacesOf(mesh);
  const double voxel_um = volume.spec().voxel_nm * 1e-3;
  AppendFewer(places, tooth, kTriangleError_um / voxel_um, fewer);
  AppendFewer(places, neighbours, kNeighbourError_um / voxel_um, fewer);
  return Packed(mesh, volume, std::move(fewer));
}

PartMesh EndMesh(Dense mesh, const cutting::Volume& volume) {
  Weld(mesh);
  std::vector<uint32_t> fewer;
  AppendFewer(PlacesOf(mesh), mesh.indices, kTriangleError_um / (volume.spec().voxel_nm * 1e-3),
              fewer);
  return Packed(mesh, volume, std::move(fewer));
}

}  // namespace

PartMeshes MeshesOf(const cutting::Volume& tooth, const std::vector<uint8_t>& changing,
                    const KeepGoing& keep_going) {
  const auto stopped = [&] { return keep_going && !keep_going(); };
  Dense still, end;
  for (size_t b = 0; b < changing.size(); ++b) {
    if (b % kBricksBetween == 0 && stopped()) return {};
    Append(surface::ExtractBrick(tooth, static_cast<int>(b)), tooth.spec(),
           changing[b] ? end : still);
  }
  PartMeshes out;
  out.end = EndMesh(std::move(end), tooth);
  if (!stopped()) out.still = StillMesh(std::move(still), tooth);
  return out;
}

CutBall CutBallOf(const cutting::Volume& initial, const cutting::Volume& tooth,
                  const std::vector<int32_t>& changed) {
  std::vector<ivec3> removed;
  const ivec3 n = tooth.spec().bricks;
  for (int32_t b : changed) {
    const ivec3 corner = ivec3(b % n.x, b / n.x % n.y, b / n.x / n.y) * kBrickSide;
    const int16_t* before = initial.Samples(b);
    const int16_t* after = tooth.Samples(b);
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (before[i] < 0 && after[i] >= 0) {
        removed.push_back(corner + ivec3(i % kBrickSide, i / kBrickSide % kBrickSide,
                                         i / kBrickSide / kBrickSide));
      }
    }
  }
  CutBall out;
  if (removed.empty()) return out;
  ivec3 lo = removed[0], hi = lo;
  for (const ivec3& voxel : removed) {
    lo = glm::min(lo, voxel);
    hi = glm::max(hi, voxel);
  }
  const dvec3 middle = (dvec3(lo) + dvec3(hi)) * 0.5;
  double most = 0;
  for (const ivec3& voxel : removed)
    most = std::max(most, Dot(dvec3(voxel) - middle, dvec3(voxel) - middle));
  const double voxel_m = tooth.spec().voxel_m();
  const dvec3 centre_m = tooth.spec().origin_m() + middle * voxel_m;
  for (int axis = 0; axis < 3; ++axis) {
    out.centre_um[static_cast<size_t>(axis)] =
        static_cast<int32_t>(std::lround(centre_m[axis] * 1e6));
  }
  out.radius_um = std::max(1, static_cast<int32_t>(std::lround(std::sqrt(most) * voxel_m * 1e6)));
  return out;
}

cutting::Volume Quantised(const cutting::Volume& volume) {
  cutting::Volume out(volume.spec());
  for (int b = 0; b < static_cast<int>(volume.spec().brick_count()); ++b) {
    const cutting::Tissue tissue = volume.UniformTissue(b);
    if (!volume.IsStored(b)) {
      out.SetUniform(b, tissue);
      continue;
    }
    const Samples samples = QuantiseBrick(volume, b);
    std::array<int16_t, kBrickVoxels> phi;
    std::ranges::transform(samples, phi.begin(), PhiOf);
    std::span<const uint8_t> labels;
    if (volume.HasLabels(b)) labels = volume.Labels(b).tissue;
    out.SetBrick(b, phi, labels, tissue);
  }
  return out;
}

}  // namespace enamel::timeline
