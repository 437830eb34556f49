#include "server/jobs/surface_blob.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace enamel::server {
namespace {

constexpr uint16_t kVersion = 1;
constexpr uint16_t kHasDeviation = 1;
constexpr double kMm = 1e3;
constexpr float kMostMm = 1000;
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

// The cell a vertex was made in, along one axis. It is on its cell's border only if a sample is
// exactly on the surface; such a sample counts as air, so the cell is on the solid's side. Vertices
// nearer to a border than the rounding of positions may get a neighbouring cell.
int CellAlong(double voxels, int normal, double rounding) {
  const double border = std::round(voxels);
  if (std::abs(voxels - border) > rounding) return static_cast<int>(std::floor(voxels));
  return static_cast<int>(border) - (normal > 0 ? 1 : 0);
}

}  // namespace

Bytes EncodeSurface(const surface::Mesh& mesh, std::span<const float> deviation_m) {
  ENAMEL_CHECK(deviation_m.empty() || deviation_m.size() == mesh.position_m.size());
  ByteWriter out;
  out.Raw(AsBytes("ENTM"));
  out.U16(kVersion);
  out.U16(deviation_m.empty() ? 0 : kHasDeviation);
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
  for (float d : deviation_m) {
    // One bit pattern for "untouched", whatever NaN came in.
    F32(out, std::isnan(d) ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(d * kMm));
  }
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t v : triangle) out.U32(v);
  }
  return out.Take();
}

Result<timeline::Deviation> DeviationOfSurface(ByteView surface, const cutting::GridSpec& spec) {
  ByteReader in(surface);
  const bool is_surface = AsText(in.Raw(4)) == "ENTM" && in.U16() == kVersion;
  const uint16_t flags = in.U16();
  const size_t vertices = in.U32();
  in.U32();  // triangles
  std::array<float, 4> frame;
  for (float& value : frame) value = std::bit_cast<float>(in.U32());
  if (!is_surface || !in.ok()) {
    return Status(Code::kInvalidInput, "expected a surface of version 1, found other bytes");
  }
  if (!(flags & kHasDeviation)) {
    return Status(Code::kNotFound, "this attempt was compared with no reference");
  }
  const auto padded = [&](size_t size) { return in.Raw((size + 3) / 4 * 4); };
  ByteReader position(padded(6 * vertices)), normal(in.Raw(4 * vertices));
  padded(vertices);  // tissues
  ByteReader deviation(in.Raw(4 * vertices));
  if (!in.ok()) {
    return Status(Code::kInvalidInput, "the surface ends early: the file was cut off");
  }
  timeline::Deviation out;
  out.spec = spec;
  const dvec3 origin_mm = spec.origin_m() * kMm;
  const double voxel_mm = spec.voxel_m() * kMm;
  for (size_t v = 0; v < vertices; ++v) {
    ivec3 cell;
    for (int i = 0; i < 3; ++i) {
      const double p_mm = frame[static_cast<size_t>(i)] + double{frame[3]} * position.U16();
      cell[i] = CellAlong((p_mm - origin_mm[i]) / voxel_mm, static_cast<int8_t>(normal.U8()),
                          frame[3] / voxel_mm);
    }
    normal.U8();
    const float mm = std::bit_cast<float>(deviation.U32());
    if (!std::isfinite(mm)) continue;
    out.cells.push_back(
        {cell, static_cast<int32_t>(std::lround(std::clamp(mm, -kMostMm, kMostMm) * 1000))});
  }
  return out;
}

}  // namespace enamel::server
