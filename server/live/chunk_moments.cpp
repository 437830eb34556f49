#include "server/live/chunk_moments.h"

#include <algorithm>

namespace enamel::server {

std::vector<LiveSample> MomentsOf(const trace::Chunk& chunk, const Uuid& station,
                                  UnixMs received_ms) {
  constexpr int32_t kAnchorPerUm = 10;
  // So many ticks of 1 kHz make LiveBoard::kRowsPerSecond rows. Counted from the chunk's end, so
  // that the newest moment is among them.
  const size_t step = std::max<size_t>(1, trace::kMaxTicksPerChunk / LiveBoard::kRowsPerSecond);
  std::vector<LiveSample> out;
  for (size_t i = (chunk.ticks.size() - 1) % step; i < chunk.ticks.size(); i += step) {
    const core::TickWitness& witness = chunk.ticks[i].witness;
    LiveSample sample;
    sample.attempt = chunk.head.attempt;
    sample.station = station;
    sample.tick = chunk.head.first_tick + i;
    for (size_t axis = 0; axis < 3; ++axis) {
      sample.anchor_um[axis] = witness.anchor_100nm[axis] / kAnchorPerUm;
      sample.force_mn[axis] = core::PressedForce_mn(witness)[axis];
    }
    sample.flags = witness.flags;
    sample.received_ms = received_ms;
    out.push_back(sample);
  }
  return out;
}

}  // namespace enamel::server
