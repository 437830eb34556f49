#include <algorithm>
#include <bit>
#include <string>

#include "common/scene/grid_blob.h"
#include "common/scoring/movement/provenance.h"

namespace enamel::scoring {
namespace {

constexpr std::string_view kLetters = "ENTP";
constexpr uint16_t kVersion = 1;
constexpr uint16_t kIncomplete = 1;  // flag
constexpr std::string_view kBlob = "provenance";
constexpr size_t kMaskBytes = cutting::kBrickVoxels / 8;

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

// Neighbours go at nearly the same time or a stroke apart: differences.
Bytes PackTicks(const std::vector<uint32_t>& ticks) {
  std::vector<uint32_t> differences(ticks.size());
  uint32_t before = 0;
  for (size_t i = 0; i < ticks.size(); ++i) {
    differences[i] = scene::Zigzag(ticks[i] - before);
    before = ticks[i];
  }
  Bytes out;
  out.reserve(ticks.size() * 4);
  scene::AppendPlanes(differences, out);
  return out;
}

Status UnpackTicks(const Bytes& packed, Provenance& out) {
  const size_t count = packed.size() / 4;
  out.tick.resize(count);
  uint32_t before = 0;
  for (size_t i = 0; i < count; ++i) {
    before += scene::Unzigzag(scene::FromPlanes(packed, count, i));
    if (before >= out.ticks) {
      return Malformed("a voxel went at tick " + std::to_string(before) + " of a recording of " +
                       std::to_string(out.ticks));
    }
    out.tick[i] = before;
  }
  return Status::Ok();
}

void WriteHeader(const Provenance& provenance, ByteWriter& out) {
  scene::WriteBlobStart(kLetters, kVersion, provenance.complete ? 0 : kIncomplete, out);
  scene::WriteGrid(provenance.spec, out);
  out.U64(provenance.ticks);
  out.U32(static_cast<uint32_t>(provenance.bricks.size()));
  out.U32(static_cast<uint32_t>(provenance.tick.size()));
}

Status ReadBricks(const Bytes& indices, const Bytes& gone, uint32_t voxels, Provenance& out) {
  ByteReader index(indices), mask(gone);
  uint32_t first = 0;
  int64_t before = -1;
  while (!index.AtEnd()) {
    Provenance::Brick brick;
    const int64_t at = index.U32();
    if (at <= before || at >= out.spec.brick_count()) {
      return Malformed("brick " + std::to_string(at) + " is out of order or outside the grid");
    }
    before = at;
    brick.index = static_cast<int32_t>(at);
    brick.first = first;
    for (uint64_t& word : brick.gone) {
      word = mask.U64();
      first += static_cast<uint32_t>(std::popcount(word));
    }
    if (first == brick.first) return Malformed("a brick in which nothing went");
    out.bricks.push_back(brick);
  }
  if (first != voxels) {
    return Malformed("its header counts " + std::to_string(voxels) + " voxels, its bricks " +
                     std::to_string(first));
  }
  return Status::Ok();
}

}  // namespace

Bytes EncodeProvenance(const Provenance& provenance) {
  ByteWriter indices, gone;
  for (const Provenance::Brick& brick : provenance.bricks) {
    indices.U32(static_cast<uint32_t>(brick.index));
    for (uint64_t word : brick.gone) gone.U64(word);
  }
  ByteWriter out;
  WriteHeader(provenance, out);
  out.Blob(scene::PackSection(indices.bytes()));
  out.Blob(scene::PackSection(gone.bytes()));
  out.Blob(scene::PackSection(PackTicks(provenance.tick)));
  return out.Take();
}

Result<Provenance> DecodeProvenance(ByteView blob) {
  ByteReader in(blob);
  ENAMEL_ASSIGN_OR_RETURN(const uint16_t flags,
                          scene::ReadBlobStart(in, kLetters, kVersion, kIncomplete, kBlob));
  Provenance out;
  ENAMEL_ASSIGN_OR_RETURN(out.spec, scene::ReadGrid(in, kBlob));
  out.ticks = in.U64();
  const uint32_t bricks = in.U32(), voxels = in.U32();
  if (!in.ok()) return Malformed("ends within its header");
  out.complete = (flags & kIncomplete) == 0;
  if (bricks > Provenance::kMaxBricks || bricks > out.spec.brick_count() ||
      voxels > uint64_t{bricks} * cutting::kBrickVoxels) {
    return Malformed(std::to_string(bricks) + " bricks with " + std::to_string(voxels) +
                     " voxels are more than there can be");
  }
  std::array<ByteView, 3> packed;
  for (ByteView& section : packed) section = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  ENAMEL_ASSIGN_OR_RETURN(const Bytes indices,
                          scene::UnpackSection(packed[0], size_t{bricks} * 4, kBlob, "bricks"));
  ENAMEL_ASSIGN_OR_RETURN(
      const Bytes gone,
      scene::UnpackSection(packed[1], size_t{bricks} * kMaskBytes, kBlob, "gone"));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes ticks,
                          scene::UnpackSection(packed[2], size_t{voxels} * 4, kBlob, "ticks"));
  ENAMEL_RETURN_IF_ERROR(ReadBricks(indices, gone, voxels, out));
  ENAMEL_RETURN_IF_ERROR(UnpackTicks(ticks, out));
  return out;
}

}  // namespace enamel::scoring
