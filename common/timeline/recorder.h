#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/base/keep_going.h"
#include "common/cutting/bur.h"
#include "common/cutting/volume.h"
#include "common/timeline/samples.h"
#include "common/timeline/timeline.h"

namespace enamel::timeline {

struct RecorderOptions {
  uint32_t rate_hz = 1000;
  // So many will be added: the samples of the last segment are exact, others coarse.
  uint64_t ticks = 0;
  std::vector<cutting::Bur> burs;
  // A tenth of a second in a frame, a minute in a segment: a segment's changes are applied within a
  // few milliseconds.
  uint32_t frame_ticks = 100;
  uint32_t segment_frames = 600;
  // The tooth changes in every so many frames, at a segment's last and at the end; the bur in all. In
  // 0.3 s a cutting bur goes about its radius. Changes of every frame take 1.6 times the
  // bytes (`enamel-lab bench timeline --change-frames 1`).
  uint32_t change_frames = 3;
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
    size_t which = 0;        // of the options' burs
  };
  // After each tick, in order: the tooth as it is now, and the bricks that this tick changed
  // (core::Core::touched).
  void Add(const cutting::Volume& volume, std::span<const int32_t> touched, const Tick& tick);

  // The file of what was noted. Once. Seconds: MeshesOf is in it.
  Bytes Finish(const cutting::Volume& volume, const KeepGoing& keep_going = {});

 private:
  // A brick's samples from the start of a segment on.
  struct Version {
    size_t segment;
    Samples samples;
  };

  void EndFrame(const cutting::Volume& volume);
  void WriteChanges(const cutting::Volume& volume);
  void EndSegment();
  void NoteChanges(int32_t brick, const Samples& before, const Samples& now);
  int32_t SlotOf(int32_t brick);
  Samples& StateOf(int32_t brick) { return states_[static_cast<size_t>(SlotOf(brick))]; }
  int CoarseIn(size_t segment) const { return segment == last_segment_ ? 0 : kCoarse; }
  Samples StateAt(int32_t brick, size_t segment) const;
  std::vector<int32_t> ChangedIn(size_t from, size_t to) const;
  Bytes KeyOf(size_t segment);

  const cutting::Volume& initial_;
  Head head_;
  // Packed, by segment.
  struct Packed {
    Bytes poses, changes;
  };
  std::vector<Packed> segments_;
  std::vector<int32_t> detailed_;
  const uint32_t change_frames_;
  size_t last_segment_ = 0;
  uint32_t ticks_in_frame_ = 0;
  FramePose pose_;
  std::vector<FramePose> poses_;  // of this segment

  std::vector<int32_t> slot_;  // per brick: index into states_, or -1
  std::vector<Samples> states_;
  // What a reader has in this segment of the bricks that changed in it.
  std::unordered_map<int32_t, Samples> read_;
  std::vector<std::vector<Version>> versions_;    // of each state, rising
  std::vector<std::vector<int32_t>> changed_in_;  // by segment, this one included: bricks, rising
  std::vector<int32_t> dirty_;                    // touched since changes were written
  uint32_t unwritten_ = 0;                        // frames since then
  std::vector<uint8_t> is_dirty_;
  ByteWriter heads_, masks_, values_;  // of this segment
};

}  // namespace enamel::timeline
