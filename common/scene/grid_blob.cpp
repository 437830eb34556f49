#include "common/scene/grid_blob.h"

#include <string>

#include "common/base/letters.h"
#include "common/base/packed.h"

namespace enamel::scene {
namespace {

constexpr int64_t kMaxOrigin_nm = 1'000'000'000;
constexpr int kLevel = 6;  // 3x smaller than level 1, still under a second for a tooth

Status Malformed(std::string_view blob, const std::string& what) {
  return Status(Code::kInvalidInput, std::string(blob) + ": " + what);
}

}  // namespace

void WriteBlobStart(std::string_view letters, uint16_t version, uint16_t flags, ByteWriter& out) {
  out.Raw(AsBytes(letters));
  out.U16(version);
  out.U16(flags);
}

Result<uint16_t> ReadBlobStart(ByteReader& in, std::string_view letters, uint16_t version,
                               uint16_t known_flags, std::string_view blob) {
  const ByteView found = in.Raw(letters.size());
  if (!in.ok() || AsText(found) != letters) {
    return Malformed(blob, OtherLetters(letters, found));
  }
  if (const uint16_t other = in.U16(); other != version) {
    return Status(Code::kVersion, std::string(blob) + ": this program reads version " +
                                      std::to_string(version) + ", found version " +
                                      std::to_string(other));
  }
  const uint16_t flags = in.U16();
  if ((flags & ~known_flags) == 0) return flags;
  return Malformed(blob, "expected flags 0" +
                             (known_flags == 0 ? "" : " or " + std::to_string(known_flags)) +
                             ", found " + std::to_string(flags));
}

void WriteGrid(const cutting::GridSpec& spec, ByteWriter& out) {
  out.I32(spec.voxel_nm);
  for (int i = 0; i < 3; ++i) out.I32(spec.bricks[i]);
  for (int64_t o : spec.origin_nm) out.I64(o);
}

Result<cutting::GridSpec> ReadGrid(ByteReader& in, std::string_view blob) {
  cutting::GridSpec spec;
  spec.voxel_nm = in.I32();
  for (int i = 0; i < 3; ++i) spec.bricks[i] = in.I32();
  for (int64_t& o : spec.origin_nm) o = in.I64();
  if (!in.ok()) return Malformed(blob, "ends within its header");
  for (int64_t o : spec.origin_nm) {
    // Here and not only in ValidateGrid: damaged bytes once gave an origin of INT64_MIN.
    if (o < -kMaxOrigin_nm || o > kMaxOrigin_nm) {
      return Malformed(blob, "its origin is over 1 m away");
    }
  }
  ENAMEL_RETURN_IF_ERROR(cutting::ValidateGrid(spec));
  return spec;
}

void AppendPlanes(std::span<const uint32_t> values, Bytes& out) {
  for (int shift = 0; shift < 32; shift += 8) {
    for (uint32_t v : values) out.push_back(static_cast<uint8_t>(v >> shift));
  }
}

uint32_t FromPlanes(ByteView planes, size_t count, size_t i) {
  uint32_t out = 0;
  for (size_t b = 0; b < 4; ++b) out |= uint32_t{planes[b * count + i]} << (8 * b);
  return out;
}

Bytes PackSection(ByteView raw) { return Pack(raw, kLevel); }

Result<Bytes> UnpackSection(ByteView packed, size_t size, std::string_view blob,
                            std::string_view section) {
  return Unpack(packed, size, std::string(blob) + ": section '" + std::string(section) + "'");
}

}  // namespace enamel::scene
