#include "server/jobs/surface_blob.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace enamel::server {
namespace {

constexpr uint16_t kVersion = 1;
constexpr uint16_t kHasDeviation = 1;
constexpr double kMm = 1e3;
constexpr double kUmPerMm = 1e3;
// Where the 16-bit positions start and how far apart they are, exactly as the file says.
struct Frame {
  glm::vec3 origin_mm{0};
  float scale_mm = 1;
};

Frame FrameOf(const surface::Mesh& mesh) {
  if (mesh.position_m.empty()) return {};
  glm::vec3 lo = mesh.position_m[0], hi = lo;
  for (const glm::vec3& p : mesh.position_m) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  glm::vec3 size = hi - lo;
  float longest = std::max(size.x, std::max(size.y, size.z));
  Frame frame;
  frame.origin_mm = glm::vec3(dvec3(lo) * kMm);
  if (longest > 0) frame.scale_mm = static_cast<float>(longest * kMm / 65535);
  return frame;
}

void F32(ByteWriter& out, float value) { out.U32(std::bit_cast<uint32_t>(value)); }

void Pad(ByteWriter& out) {
  while (out.size() % 4 != 0) out.U8(0);
}

uint8_t Signed8(float unit) {
  return static_cast<uint8_t>(
      static_cast<int8_t>(std::lround(std::clamp(unit, -1.0f, 1.0f) * 127)));
}

void WritePositions(const surface::Mesh& mesh, const Frame& frame, ByteWriter& out) {
  for (const glm::vec3& p : mesh.position_m) {
    for (int i = 0; i < 3; ++i) {
      double steps = (p[i] * kMm - frame.origin_mm[i]) / frame.scale_mm;
      out.U16(static_cast<uint16_t>(std::lround(std::clamp(steps, 0.0, 65535.0))));
    }
  }
  Pad(out);
}

Bytes Encode(const surface::Mesh& mesh, std::span<const float> deviation_mm) {
  ByteWriter out;
  out.Raw(AsBytes("ENTM"));
  out.U16(kVersion);
  out.U16(deviation_mm.empty() ? 0 : kHasDeviation);
  out.U32(static_cast<uint32_t>(mesh.position_m.size()));
  out.U32(static_cast<uint32_t>(mesh.triangles.size()));
  Frame frame = FrameOf(mesh);
  for (int i = 0; i < 3; ++i) F32(out, frame.origin_mm[i]);
  F32(out, frame.scale_mm);
  WritePositions(mesh, frame, out);
  for (const glm::vec3& n : mesh.normal) {
    for (int i = 0; i < 3; ++i) out.U8(Signed8(n[i]));
    out.U8(0);
  }
  for (uint8_t t : mesh.tissue) out.U8(t);
  Pad(out);
  for (float d : deviation_mm) F32(out, d);
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t v : triangle) out.U32(v);
  }
  return out.Take();
}

}  // namespace

CelledSurface CelledSurfaceOf(const cutting::Volume& volume) {
  CelledSurface out;
  out.mesh = surface::ExtractSurface(volume, &out.cell);
  return out;
}

Bytes EncodeSurface(const surface::Mesh& mesh) { return Encode(mesh, {}); }

Bytes EncodeSurface(const CelledSurface& surface, const timeline::Deviation& deviation) {
  const timeline::DeviationByCell known(deviation);
  std::vector<float> deviation_mm(surface.cell.size(), std::numeric_limits<float>::quiet_NaN());
  for (size_t v = 0; v < surface.cell.size(); ++v) {
    if (const auto um = known.At_um(surface.cell[v])) {
      deviation_mm[v] = static_cast<float>(*um / kUmPerMm);
    }
  }
  return Encode(surface.mesh, deviation_mm);
}

}  // namespace enamel::server
