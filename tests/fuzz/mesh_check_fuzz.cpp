#include <array>
#include <string_view>

#include "common/import/mesh_file_check.h"

// First byte: the kind of file; the rest: its bytes. Refused or not, and never read past the end.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  constexpr std::array<std::string_view, 5> kKinds = {"stl", "ply", "obj", "off", "other"};
  if (size == 0) return 0;
  const ByteView file(data + 1, size - 1);
  (void)import::CheckMeshBytes(file, kKinds[data[0] % kKinds.size()]).ok();
  return 0;
}
