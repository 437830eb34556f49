#include <algorithm>
#include <string>

#include "common/scene/grid_blob.h"
#include "common/timeline/timeline.h"

namespace enamel::timeline {
namespace {

constexpr std::string_view kLetters = "ENTT";
constexpr uint16_t kVersion = 1;
constexpr std::string_view kBlob = "surface timeline";
constexpr size_t kFixedBytes = 136, kOutlineBytes = 8, kSegmentBytes = 24;

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

Status Bounded(const char* what, uint64_t found, uint64_t least, uint64_t most) {
  if (found >= least && found <= most) return Status::Ok();
  return Malformed("expected " + std::string(what) + " from " + std::to_string(least) + " to " +
                   std::to_string(most) + ", found " + std::to_string(found));
}

void WriteFixed(const Head& head, ByteWriter& out) {
  scene::WriteBlobStart(kLetters, kVersion, 0, out);
  scene::WriteGrid(head.spec, out);
  out.Raw(head.start.view());
  out.U64(head.ticks);
  out.U32(head.rate_hz);
  out.U32(head.frame_ticks);
  out.U32(head.segment_frames);
  out.U32(static_cast<uint32_t>(head.OutlinePoints()));
  out.U32(static_cast<uint32_t>(head.segments.size()));
  for (int32_t place : head.cut.centre_um) out.I32(place);
  out.I32(head.cut.radius_um);
  out.U32(head.end_bytes);
  out.U32(head.still_bytes);
  out.U32(head.changing_bytes);
}

// Where the segments are, once the sizes of all are known: the last one first.
void PlaceSegments(Head& head) {
  uint64_t offset =
      head.bytes() + uint64_t{head.end_bytes} + head.still_bytes + head.changing_bytes;
  for (size_t i = head.segments.size(); i-- > 0;) {
    head.segments[i].offset = offset;
    offset += head.segments[i].bytes();
  }
}

}  // namespace

uint32_t Head::FramesIn(size_t segment) const {
  const uint64_t first = uint64_t{segment} * segment_frames;
  return static_cast<uint32_t>(std::min<uint64_t>(segment_frames, frames() - first));
}

size_t Head::OutlinePoints() const {
  size_t out = 0;
  for (const std::vector<OutlinePoint>& outline : outlines) out += outline.size();
  return out;
}

size_t Head::bytes() const {
  return kFixedBytes + OutlinePoints() * kOutlineBytes + segments.size() * kSegmentBytes;
}

uint64_t Head::file_bytes() const {
  uint64_t out = bytes() + uint64_t{end_bytes} + still_bytes + changing_bytes;
  for (const Segment& segment : segments) out += segment.bytes();
  return out;
}

Bytes EncodeHead(const Head& head) {
  ByteWriter out;
  WriteFixed(head, out);
  for (const std::vector<OutlinePoint>& outline : head.outlines) {
    for (const OutlinePoint& point : outline) {
      out.I32(point.z_nm);
      out.I32(point.radius_nm);
    }
  }
  for (const Segment& segment : head.segments) {
    out.U32(segment.pose_bytes);
    out.U32(segment.key_bytes);
    out.U32(segment.change_bytes);
    out.U32(segment.key_bricks);
    out.U32(segment.key_start);
    out.U32(segment.change_size);
  }
  return out.Take();
}

Result<Head> DecodeHead(ByteView bytes) {
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(scene::ReadBlobStart(in, kLetters, kVersion, 0, kBlob).status());
  Head out;
  ENAMEL_ASSIGN_OR_RETURN(out.spec, scene::ReadGrid(in, kBlob));
  const ByteView start = in.Raw(out.start.bytes.size());
  out.ticks = in.U64();
  out.rate_hz = in.U32();
  out.frame_ticks = in.U32();
  out.segment_frames = in.U32();
  const uint32_t points = in.U32(), segments = in.U32();
  for (int32_t& place : out.cut.centre_um) place = in.I32();
  out.cut.radius_um = in.I32();
  out.end_bytes = in.U32();
  out.still_bytes = in.U32();
  out.changing_bytes = in.U32();
  if (!in.ok()) return Malformed("ends within its head");
  out.start = Sha256::FromBytes(start);
  ENAMEL_RETURN_IF_ERROR(Bounded("a rate in Hz", out.rate_hz, 1, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(Bounded("ticks of a frame", out.frame_ticks, 1, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(Bounded("frames of a segment", out.segment_frames, 1, 100'000));
  // Before frames(), whose type would cut it.
  ENAMEL_RETURN_IF_ERROR(
      Bounded("ticks", out.ticks, 0, uint64_t{Head::kMaxFrames} * out.frame_ticks));
  ENAMEL_RETURN_IF_ERROR(Bounded("points of outlines", points, 0, Head::kMaxOutline));
  const uint32_t expected = (out.frames() + out.segment_frames - 1) / out.segment_frames;
  ENAMEL_RETURN_IF_ERROR(Bounded("segments", segments, expected, expected));
  ENAMEL_RETURN_IF_ERROR(Bounded("segments", segments, 0, Head::kMaxSegments));
  for (uint32_t i = 0; i < points && in.ok(); ++i) {
    const int32_t z_nm = in.I32(), radius_nm = in.I32();
    if (z_nm == 0) out.outlines.emplace_back();
    if (out.outlines.empty()) return Malformed("the outline of a bur does not begin at its tip");
    out.outlines.back().push_back({z_nm, radius_nm});
    if (radius_nm < 0) return Malformed("a radius of the bur is below 0");
  }
  if (out.cut.radius_um < 0) return Malformed("the radius of what was removed is below 0");
  for (uint32_t i = 0; i < segments && in.ok(); ++i) {
    Segment segment;
    segment.pose_bytes = in.U32();
    segment.key_bytes = in.U32();
    segment.change_bytes = in.U32();
    segment.key_bricks = in.U32();
    segment.key_start = in.U32();
    segment.change_size = in.U32();
    if (segment.key_bricks > out.spec.brick_count()) {
      return Malformed("a key frame has more bricks than the grid");
    }
    if (segment.key_start > segment.key_bricks) {
      return Malformed("a key frame has more bricks as at the start than bricks");
    }
    out.segments.push_back(segment);
  }
  if (!in.ok()) return Malformed("ends within its head");
  PlaceSegments(out);
  return out;
}

}  // namespace enamel::timeline
