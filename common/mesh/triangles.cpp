#include "common/mesh/triangles.h"

#include <bit>
#include <cmath>
#include <string>

namespace enamel::mesh {
namespace {

constexpr std::string_view kMagic = "ENTR";

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, "the mesh reader's answer: " + what);
}

}  // namespace

Bytes EncodeMesh(const NamedMesh& named) {
  const Triangles& mesh = named.mesh;
  ByteWriter out;
  out.Raw(AsBytes(kMagic));
  out.U32(static_cast<uint32_t>(mesh.vertices.size()));
  out.U32(static_cast<uint32_t>(mesh.indices.size()));
  out.U32(static_cast<uint32_t>(named.parts.size()));
  out.U32(static_cast<uint32_t>(named.notes.size()));
  for (const dvec3& v : mesh.vertices) {
    for (int i = 0; i < 3; ++i) out.U64(std::bit_cast<uint64_t>(v[i]));
  }
  for (const auto& t : mesh.indices) {
    for (uint32_t i : t) out.U32(i);
  }
  for (const MeshPart& part : named.parts) {
    out.U32(part.first);
    out.U32(part.count);
    for (const std::string* text : {&part.name, &part.material}) {
      out.U8(static_cast<uint8_t>(text->size()));
      out.Raw(AsBytes(*text));
    }
  }
  for (const std::string& note : named.notes) {
    out.U8(static_cast<uint8_t>(note.size()));
    out.Raw(AsBytes(note));
  }
  return out.Take();
}

Result<NamedMesh> DecodeMesh(ByteView bytes) {
  ByteReader in(bytes);
  ByteView magic = in.Raw(kMagic.size());
  const size_t n_vertices = in.U32(), n_triangles = in.U32(), n_parts = in.U32(),
               n_notes = in.U32();
  if (!in.ok() || AsText(magic) != kMagic) return Malformed("does not begin as one");
  // Before any memory of that size is taken: the child may have been taken over by its file.
  if (n_vertices > kMaxVertices || n_triangles > kMaxTriangles || n_parts > kMaxParts ||
      n_notes > kMaxNotes || in.remaining() < 24 * n_vertices + 12 * n_triangles) {
    return Malformed("its size does not match its header");
  }
  NamedMesh out;
  out.mesh.vertices.resize(n_vertices);
  out.mesh.indices.resize(n_triangles);
  for (dvec3& v : out.mesh.vertices) {
    for (int i = 0; i < 3; ++i) v[i] = std::bit_cast<double>(in.U64());
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
      return Malformed("a coordinate is not a finite number");
    }
  }
  for (auto& t : out.mesh.indices) {
    for (uint32_t& i : t) {
      i = in.U32();
      if (i >= n_vertices)
        return Malformed("a triangle names vertex " + std::to_string(i) + " of " +
                         std::to_string(n_vertices));
    }
  }
  for (size_t k = 0; k < n_parts; ++k) {
    MeshPart part;
    part.first = in.U32(), part.count = in.U32();
    part.name = AsText(in.Raw(in.U8()));
    part.material = AsText(in.Raw(in.U8()));
    if (!in.ok() || part.first > n_triangles || part.count > n_triangles - part.first)
      return Malformed("a part is not within it");
    out.parts.push_back(std::move(part));
  }
  for (size_t k = 0; k < n_notes; ++k) out.notes.emplace_back(AsText(in.Raw(in.U8())));
  if (!in.ok()) return Malformed("is cut short");
  if (in.remaining() != 0) return Malformed("more follows its end");
  return out;
}

double SignedVolume(const std::vector<dvec3>& vertices,
                    const std::vector<std::array<uint32_t, 3>>& triangles) {
  if (triangles.empty()) return 0;
  // From a vertex of its own: far from the file's origin the products would cancel.
  const dvec3 o = vertices[triangles[0][0]];
  double sum = 0;
  for (const auto& t : triangles)
    sum += Dot(vertices[t[0]] - o, glm::cross(vertices[t[1]] - o, vertices[t[2]] - o));
  return sum / 6;
}

double SignedVolume(const Triangles& mesh) { return SignedVolume(mesh.vertices, mesh.indices); }

void BoxOf(const std::vector<dvec3>& vertices,
           const std::vector<std::array<uint32_t, 3>>& triangles, dvec3& lo, dvec3& hi) {
  lo = hi = vertices[triangles[0][0]];
  for (const auto& t : triangles) {
    for (uint32_t i : t) lo = glm::min(lo, vertices[i]), hi = glm::max(hi, vertices[i]);
  }
}

double SurfaceArea(const Triangles& mesh) {
  double sum = 0;
  for (const auto& t : mesh.indices) {
    sum += 0.5 * glm::length(glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                        mesh.vertices[t[2]] - mesh.vertices[t[0]]));
  }
  return sum;
}

}  // namespace enamel::mesh
