#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/cutting/volume.h"
#include "common/timeline/parts.h"

// The head of a surface timeline: format "ENTT", version 1 (schemas/surface_timeline.md). A
// timeline holds the parts of a tooth (parts.h, changing.h) and its changes in frames of equally
// many ticks; start_tooth.h holds the whole tooth before. recorder.h writes it, player.h reads it.
namespace enamel::timeline {

// One frame's bur, and how long the frame took.
struct FramePose {
  std::array<int32_t, 3> tip_um{};  // scene frame, where the bur cuts, after the frame's last tick
  std::array<int8_t, 3> axis{};     // toward the shank, /127
  bool turning = false;
  uint32_t gap_ticks = 0;  // that passed within the frame and were not recorded
  uint8_t bur = 0;         // which of the head's outlines

  bool operator==(const FramePose&) const = default;
};

// A point of a bur's outline, from the tip to the shank's end.
struct OutlinePoint {
  int32_t z_nm = 0, radius_nm = 0;
  bool operator==(const OutlinePoint&) const = default;
};

// Where a part of the file is that can be read by itself.
struct Segment {
  uint64_t offset = 0;  // from the start of the file; the last segment comes first there
  uint32_t pose_bytes = 0, key_bytes = 0, change_bytes = 0;  // packed, one after the other
  uint32_t key_bricks = 0;                                   // in the key frame
  uint32_t key_start = 0;                                    // of them still as at the start
  uint32_t change_size = 0;                                  // of the changes, unpacked
  uint64_t bytes() const { return uint64_t{pose_bytes} + key_bytes + change_bytes; }
};

// In a key frame, beside the number of a brick that is still as at the start.
inline constexpr uint32_t kAsAtStart = 1u << 31;

// The segment whose key frame that of `segment` is read with (schemas/surface_timeline.md, "Key
// frame"). Requires: segment < last.
constexpr size_t KeyParent(size_t segment, size_t last) {
  const size_t before_end = last - segment;
  return last - (before_end & (before_end - 1));
}

struct Head {
  // More frames than this are refused: two weeks of them at ten a second.
  static constexpr uint32_t kMaxFrames = 12'000'000;
  static constexpr uint32_t kMaxSegments = 65'536;
  static constexpr uint32_t kMaxOutline = 256;  // points of all outlines

  cutting::GridSpec spec;
  Sha256 start;  // of the start tooth's file
  uint64_t ticks = 0;
  uint32_t rate_hz = 0;
  uint32_t frame_ticks = 0;     // recorded ticks in a frame; the last may have fewer
  uint32_t segment_frames = 0;  // frames in a segment; the last may have fewer
  CutBall cut;                  // by the end
  // Of the parts, which follow the head in this order.
  uint32_t end_bytes = 0, still_bytes = 0, changing_bytes = 0;
  // Of each bur. A bur's begins with its only point at place 0.
  std::vector<std::vector<OutlinePoint>> outlines;
  std::vector<Segment> segments;

  uint32_t frames() const { return static_cast<uint32_t>((ticks + frame_ticks - 1) / frame_ticks); }
  uint32_t FramesIn(size_t segment) const;
  size_t OutlinePoints() const;
  size_t bytes() const;
  // Of the whole file.
  uint64_t file_bytes() const;
};

Bytes EncodeHead(const Head& head);
// The head of a file that begins with `bytes`. Bounded. Errors: kVersion; kInvalidInput for
// everything that the document does not allow, also when the head is incomplete.
Result<Head> DecodeHead(ByteView bytes);

}  // namespace enamel::timeline
