#include "common/timeline/part_mesh.h"

#include <string>

#include "common/base/check.h"
#include "common/cutting/tissue.h"
#include "common/scene/grid_blob.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

constexpr std::string_view kBlob = "mesh";

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

Bytes PositionsOf(const PartMesh& mesh) {
  Bytes out;
  std::vector<uint32_t> column(mesh.vertices.size());
  for (size_t axis = 0; axis < 3; ++axis) {
    uint32_t before = 0;
    for (size_t i = 0; i < column.size(); ++i) {
      const uint32_t now = mesh.vertices[i].at[axis];
      column[i] = scene::Zigzag(now - before);
      before = now;
    }
    scene::AppendPlanes(column, out);
  }
  return out;
}

Bytes NormalsOf(const PartMesh& mesh) {
  Bytes out;
  for (size_t axis = 0; axis < 2; ++axis) {
    uint8_t before = 0;
    for (const PartMesh::Vertex& vertex : mesh.vertices) {
      const auto now = static_cast<uint8_t>(vertex.normal[axis]);
      out.push_back(static_cast<uint8_t>(now - before));
      before = now;
    }
  }
  return out;
}

// What a number of a strip stands for; anything above: how far back from the next vertex it is.
constexpr uint32_t kNextVertex = 0, kNewStrip = 1, kBack = 1;

// Strips of triangles, each vertex as its distance from the next one that was not named yet: most
// are 0 (Chun, "WebGL models: end-to-end", 2012).
std::vector<uint32_t> StripsOf(const PartMesh& mesh) {
  std::vector<uint32_t> out;
  uint32_t next = 0;
  for (uint32_t vertex : mesh.strips) {
    if (vertex == PartMesh::kNewStrip) {
      out.push_back(kNewStrip);
      continue;
    }
    ENAMEL_CHECK(vertex <= next);
    out.push_back(vertex == next ? kNextVertex : next - vertex + kBack);
    next += vertex == next;
  }
  ENAMEL_CHECK(next == mesh.vertices.size());
  return out;
}

Status ReadStrips(ByteView planes, size_t vertices, size_t count, PartMesh& out) {
  uint32_t next = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t code = scene::FromPlanes(planes, count, i);
    if (code == kNewStrip) {
      out.strips.push_back(PartMesh::kNewStrip);
      continue;
    }
    const uint32_t back = code == kNextVertex ? 0 : code - kBack;
    if (back > next || (back == 0 && next == vertices)) {
      return Malformed("a strip names a vertex beyond the last");
    }
    out.strips.push_back(next - back);
    next += back == 0;
  }
  return next == vertices ? Status::Ok() : Malformed("a vertex belongs to no strip");
}

}  // namespace

std::vector<std::array<uint32_t, 3>> PartMesh::Triangles() const {
  std::vector<std::array<uint32_t, 3>> out;
  size_t begin = 0;
  for (size_t i = 0; i < strips.size(); ++i) {
    if (strips[i] == kNewStrip) begin = i + 1;
    if (i < begin + 2) continue;
    const uint32_t a = strips[i - 2], b = strips[i - 1], c = strips[i];
    if (a == b || b == c || c == a) continue;
    // Every second one turns the other way.
    if ((i - begin) % 2 == 0) {
      out.push_back({a, b, c});
    } else {
      out.push_back({b, a, c});
    }
  }
  return out;
}

Bytes EncodeMesh(const PartMesh& mesh) {
  ENAMEL_CHECK(mesh.vertices.size() <= PartMesh::kMost && mesh.strips.size() <= PartMesh::kMost);
  Bytes tissues, strips;
  scene::AppendPlanes(StripsOf(mesh), strips);
  for (const PartMesh::Vertex& vertex : mesh.vertices) tissues.push_back(vertex.tissue);
  ByteWriter out;
  out.U32(static_cast<uint32_t>(mesh.vertices.size()));
  out.U32(static_cast<uint32_t>(mesh.strips.size()));
  for (const Bytes& section : {PositionsOf(mesh), NormalsOf(mesh), tissues, strips}) {
    out.Blob(Deflate(section, Effort::kMost));
  }
  return out.Take();
}

Result<PartMesh> DecodeMesh(ByteView blob) {
  ByteReader in(blob);
  const size_t vertices = in.U32(), count = in.U32();
  std::array<ByteView, 4> packed;
  for (ByteView& section : packed) section = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  if (vertices > PartMesh::kMost || count > PartMesh::kMost) {
    return Malformed("has more vertices or strips than this version reads");
  }
  ENAMEL_ASSIGN_OR_RETURN(const Bytes positions,
                          Inflate(packed[0], 12 * vertices, kBlob, "positions"));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes normals, Inflate(packed[1], 2 * vertices, kBlob, "normals"));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes tissues, Inflate(packed[2], vertices, kBlob, "tissues"));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes strips, Inflate(packed[3], 4 * count, kBlob, "strips"));
  PartMesh out;
  ENAMEL_RETURN_IF_ERROR(ReadStrips(strips, vertices, count, out));
  out.vertices.resize(vertices);
  std::array<uint32_t, 3> at{};
  std::array<uint8_t, 2> normal{};
  for (size_t i = 0; i < vertices; ++i) {
    PartMesh::Vertex& vertex = out.vertices[i];
    for (size_t axis = 0; axis < 3; ++axis) {
      const ByteView column = ByteView(positions).subspan(4 * vertices * axis, 4 * vertices);
      at[axis] += scene::Unzigzag(scene::FromPlanes(column, vertices, i));
    }
    for (size_t axis = 0; axis < 2; ++axis) {
      normal[axis] = static_cast<uint8_t>(normal[axis] + normals[vertices * axis + i]);
      vertex.normal[axis] = static_cast<int8_t>(normal[axis]);
    }
    vertex.at = at;
    vertex.tissue = tissues[i];
    if (vertex.tissue >= cutting::kTissueCount) return Malformed("a vertex is of no tissue");
  }
  return out;
}

}  // namespace enamel::timeline
