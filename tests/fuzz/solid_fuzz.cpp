#include <algorithm>

#include "common/base/check.h"
#include "common/cutting/volume.h"
#include "common/import/import_tooth.h"

// Bytes as a small mesh: first byte the number of vertices, then three bytes each in sixteenths of
// a millimetre, then triangles. Refused, or a tooth of at most its bounding box.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  ByteReader in({data, std::min<size_t>(size, 1000)});
  mesh::Triangles mesh;
  const int vertices = in.U8() + 1;
  for (int i = 0; i < vertices && in.remaining() >= 3; ++i) {
    const double x = in.U8(), y = in.U8(), z = in.U8();
    mesh.vertices.emplace_back(x / 16, y / 16, z / 16);
  }
  while (in.remaining() >= 3 && !mesh.vertices.empty()) {
    std::array<uint32_t, 3> t{in.U8(), in.U8(), in.U8()};
    for (uint32_t& i : t) i %= static_cast<uint32_t>(mesh.vertices.size());
    mesh.indices.push_back(t);
  }
  import::ImportOptions options{.tooth = 46};
  options.voxel_nm = 500'000;
  options.threads = 1;
  auto tooth = import::ImportTriangles(mesh, "fuzz", options);
  if (!tooth.ok()) {
    ENAMEL_CHECK(!tooth.status().message().empty());
    return 0;
  }
  double solid_mm3 = 0, box_mm3 = 1;
  for (double t : cutting::SolidVolume_m3(tooth->volume)) solid_mm3 += t * 1e9;
  dvec3 lo, hi;
  mesh::BoxOf(mesh.vertices, mesh.indices, lo, hi);
  for (int k = 0; k < 3; ++k) box_mm3 *= hi[k] - lo[k] + 1;  // a voxel around
  ENAMEL_CHECK(solid_mm3 >= 0 && solid_mm3 <= box_mm3);
  return 0;
}
