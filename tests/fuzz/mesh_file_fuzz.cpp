#include <array>
#include <string>

#include "common/base/check.h"
#include "common/import/mesh_reader.h"

// First byte: the kind of file; the rest: its bytes. Refused, or a mesh that reads back from the
// form in which the import child sends it.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  static const std::array<std::string, 4> kKinds = {"stl", "ply", "obj", "off"};
  if (size == 0) return 0;
  auto mesh = import::ReadMesh(ByteView(data + 1, size - 1), kKinds[data[0] % kKinds.size()]);
  if (!mesh.ok()) {
    ENAMEL_CHECK(!mesh.status().message().empty());
    return 0;
  }
  auto back = mesh::DecodeMesh(mesh::EncodeMesh(*mesh));
  ENAMEL_CHECK(back.ok() && back->mesh.indices == mesh->mesh.indices);
  ENAMEL_CHECK(back->mesh.vertices == mesh->mesh.vertices && back->notes == mesh->notes);
  ENAMEL_CHECK(back->parts.size() == mesh->parts.size());
  return 0;
}
