#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/keep_going.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "common/timeline/samples.h"
#include "common/timeline/timeline.h"

namespace enamel::timeline {

struct RecorderOptions {
  uint32_t rate_hz = 1000;
  cutting::Bur bur;
  // A tenth of a second in a frame, half a minute in a segment: a segment's changes are applied
  // within a few milliseconds, and a key frame is worth as much as the changes of several minutes.
  uint32_t frame_ticks = 100;
  uint32_t segment_frames = 300;
  // Bricks to keep in detail though nothing changes there: those that a reference has cut.
  std::vector<int32_t> detailed;
};

// Notes how a tooth changes while the core runs, and gives the surface timeline of it. Reads the
// bricks that a tick has touched and changes nothing. Thread safety: none. Not real-time.
class Recorder {
 public:
  // `initial`: the tooth before the first tick, of the grid of every volume that follows. It must
  // outlive the recorder. `start`: hash of its start tooth's file (start_tooth.h).
  Recorder(const cutting::Volume& initial, const Sha256& start, const RecorderOptions& options);

  struct Tick {
    cutting::Pose bur;  // where it cuts
    bool turning = false;
    uint32_t gap_ticks = 0;  // before this tick
  };
  // After each tick, in order: the tooth as it is now, and the bricks that this tick changed
  // (core::Core::touched).
  void Add(const cutting::Volume& volume, std::span<const int32_t> touched, const Tick& tick);

  // The file of what was noted. Once. Seconds: MeshesOf is in it.
  Bytes Finish(const cutting::Volume& volume, const KeepGoing& keep_going = {});

 private:
  void EndFrame(const cutting::Volume& volume);
  void EndSegment();
  void NoteChanges(int32_t brick, const Samples& now);
  Samples& StateOf(int32_t brick);

  const cutting::Volume& initial_;
  Head head_;
  std::vector<Bytes> segments_;
  std::vector<int32_t> detailed_;
  uint32_t ticks_in_frame_ = 0;
  FramePose pose_;
  std::vector<FramePose> poses_;  // of this segment

  std::vector<int32_t> slot_;  // per brick: index into states_, or -1
  std::vector<Samples> states_;
  std::vector<int32_t> changed_;  // bricks whose samples are no longer the start's, rising
  std::vector<int32_t> dirty_;    // touched in this frame
  std::vector<uint8_t> is_dirty_;
  ByteWriter heads_, masks_, values_;  // of this segment
  Bytes key_;                          // of this segment, packed
  uint32_t key_bricks_ = 0;
};

}  // namespace enamel::timeline
