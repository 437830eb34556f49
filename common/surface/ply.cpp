#include "common/surface/ply.h"

#include <bit>
#include <string>

namespace enamel::surface {
namespace {

void Float(float v, ByteWriter& out) { out.U32(std::bit_cast<uint32_t>(v)); }

std::string Head(const Mesh& mesh) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment unit: mm\n";
  text += "element vertex " + std::to_string(mesh.position_m.size()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    text += std::string("property float ") + name + "\n";
  }
  text += "property uchar tissue\n";
  text += "element face " + std::to_string(mesh.triangles.size()) + "\n";
  text += "property list uchar uint vertex_indices\nend_header\n";
  return text;
}

}  // namespace

Bytes EncodePly(const Mesh& mesh) {
  ByteWriter out;
  out.Raw(AsBytes(Head(mesh)));
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) Float(mesh.position_m[i][axis] * 1e3f, out);
    for (int axis = 0; axis < 3; ++axis) Float(mesh.normal[i][axis], out);
    out.U8(mesh.tissue[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    out.U8(3);
    for (uint32_t corner : triangle) out.U32(corner);
  }
  return out.Take();
}

}  // namespace enamel::surface
