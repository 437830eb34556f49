#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/core/core.h"
#include "common/trace/trace.h"

// Keyframes of one recording's replay: states of the core at ends of chunks, from which a replay
// may start (schemas/trace_format.md, "Keyframes"). A cache for looking at a moment, never
// evidence: scoring and verification re-run from the first tick.
namespace enamel::trace {

inline constexpr size_t kMaxKeyframeBytes = size_t{64} << 20;
inline constexpr size_t kMaxKeyframes = 4096;

// The place of a keyframe in its recording.
struct KeyframePlace {
  uint64_t ticks = 0;  // stepped so far
  uint32_t chunks = 0;
  uint64_t gap_ticks = 0;
  Sha256 chain;  // of the last chunk
  uint64_t state_hash = 0;

  bool operator==(const KeyframePlace&) const = default;
};

// Thread safety: none. Not real-time.
class Keyframes {
 public:
  // None yet. `header_hash`: HashSha256 of the recording's encoded header.
  explicit Keyframes(const Sha256& header_hash) : header_hash_(header_hash) {}
  // Errors, all of which mean "do without and make new ones": kVersion for another format, core or
  // build, kConflict for another recording, kInvalidInput and kTooLarge for damage. A file that
  // ends inside a keyframe gives those before it.
  static Result<Keyframes> Decode(ByteView bytes, const Sha256& header_hash);
  Bytes Encode() const;

  size_t size() const { return frames_.size(); }
  const KeyframePlace& place(size_t i) const { return frames_[i].place; }
  // Forgets keyframe i and those after it.
  void Truncate(size_t i) { frames_.resize(std::min(i, frames_.size())); }

  // Saves `core`, whose state is at `place`, after the last keyframe. `changed`: bricks that
  // changed since that one (since the start for the first). Requires: place.chunks above the last
  // one's.
  void Add(core::Core& core, const KeyframePlace& place, std::span<const int32_t> changed);
  // Puts keyframe i into a core that has not stepped yet, made with the recording's parameters and
  // volume. Errors: kInvalidInput; the core is then of no use.
  Status Restore(size_t i, core::Core& core) const;

 private:
  struct Frame {
    KeyframePlace place;
    uint32_t bricks = 0, state_size = 0;
    Bytes samples, state;  // zstd frames
  };
  static Result<Frame> DecodeFrame(ByteView content);
  static void EncodeFrame(const Frame& frame, ByteWriter& out);

  Sha256 header_hash_;
  std::vector<Frame> frames_;
};

}  // namespace enamel::trace
