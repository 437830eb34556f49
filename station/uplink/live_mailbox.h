#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/triple_buffer.h"

namespace enamel::station {

// A moment of an attempt for its viewers (schemas/wire/station.proto, LiveState).
struct LivePoint {
  uint64_t ticks = 0;                  // stepped so far; 0: none yet
  std::array<int32_t, 3> anchor_um{};  // from the device's origin, along the scene's axes
  std::array<int32_t, 3> force_mn{};   // on the operator
  uint32_t flags = 0;                  // witness flags
};

// Passes the newest moment from the tick to the uplink; older ones are overwritten unread. Thread
// safety: one writer, one reader. Real-time: Write is safe.
class LiveMailbox {
 public:
  void Write(const LivePoint& point) noexcept { newest_.Write(point); }
  // The newest moment; nothing if it was read before.
  std::optional<LivePoint> Take() {
    const LivePoint& point = newest_.Read();
    if (point.ticks == read_) return std::nullopt;
    read_ = point.ticks;
    return point;
  }

 private:
  TripleBuffer<LivePoint> newest_;
  uint64_t read_ = 0;
};

}  // namespace enamel::station
