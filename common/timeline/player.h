#pragma once

#include <span>
#include <vector>

#include "common/cutting/volume.h"
#include "common/timeline/start_tooth.h"
#include "common/timeline/timeline.h"

namespace enamel::timeline {

// Reads a surface timeline: the tooth as it was after any frame. Memory and work are bounded by the
// sizes of the two files (a packed byte gives at most 1032). The same as the page's reader
// (web/src/tooth/timeline.ts), in C++. Thread safety: none. Not real-time.
class Player {
 public:
  // Both files whole; what they hold is copied. Errors: kVersion, kInvalidInput; kConflict when the
  // timeline belongs to another start tooth.
  static Result<Player> Open(ByteView start_tooth, ByteView timeline);

  const Head& head() const { return head_; }
  // The tooth after this many frames; 0: before the first tick. Forward within a segment only the
  // frames between are applied. Errors: kInvalidInput when the file is damaged; then the tooth is
  // that of no moment. Requires: frames <= head().frames().
  Status Seek(uint32_t frames);
  // The poses of a segment's frames. Errors: kInvalidInput.
  Result<std::vector<FramePose>> Poses(size_t segment) const;

  uint32_t at() const { return at_; }
  Samples BrickSamples(int brick) const;
  cutting::Tissue TissueAt(const ivec3& voxel) const;
  // With distances in steps of 1/64 voxel, within a voxel of the surface.
  cutting::Volume ToVolume() const;

 private:
  Player() = default;
  // The source of a segment's changes, frame by frame.
  struct Changes {
    Bytes raw;
    size_t head = 0, head_end = 0, mask = 0, mask_end = 0, value = 0;
  };
  ByteView Part(size_t segment, int part) const;
  Status EnterSegment(size_t segment);
  Status ReadKey(size_t segment);
  Status ApplyFrame();
  Status ApplyBrick(int64_t brick);
  Samples& StateOf(int64_t brick);
  int CoarseIn(size_t segment) const { return segment + 1 < head_.segments.size() ? kCoarse : 0; }
  void Reset();

  StartTooth start_;
  std::vector<int32_t> sample_slot_, label_slot_;  // per brick: index into start_, or -1
  Head head_;
  Bytes file_;
  uint32_t at_ = 0;
  size_t segment_ = SIZE_MAX;  // whose changes are open
  Changes changes_;
  std::vector<int32_t> slot_;  // per brick: index into states_, or -1: as at the start
  std::vector<int32_t> owner_;
  std::vector<Samples> states_;
};

}  // namespace enamel::timeline
