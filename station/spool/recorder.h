#pragma once

#include <algorithm>
#include <atomic>
#include <functional>

#include "common/base/result.h"
#include "station/loop/tick_loop.h"
#include "station/spool/spool.h"

namespace enamel::station {

// Takes samples from the loop's ring, makes signed chunks of them and puts those into the spool.
// Thread safety: one thread calls Pump, Flush and Finish; chunks() and ticks() from any. Real-time: never;
// this is the other end of the ring.
class Recorder {
 public:
  // Half a second, the most a crash can lose, at any rate.
  static constexpr size_t TicksPerChunk(uint32_t rate_hz) {
    return std::clamp<size_t>(rate_hz / 2, 1, trace::kMaxTicksPerChunk);
  }
  static constexpr size_t kTicksPerChunk = 500;  // at 1 kHz

  // All must outlive the recorder. Requires: the spool has the attempt.
  Recorder(Spool& spool, SampleRing& ring, const Uuid& attempt, const Sha256& header_hash,
           const trace::SecretKey& station_key);
  // Continues after the chunks already in the spool; `place` is the end of their chain.
  Recorder(Spool& spool, SampleRing& ring, const Uuid& attempt, const trace::ChainState& place,
           const trace::SecretKey& station_key, size_t ticks_per_chunk = kTicksPerChunk);

  // Takes the ring's samples and spools each full chunk. True when there were any. Errors: the
  // spool's; call again once the cause is repaired, and nothing is lost.
  Result<bool> Pump();
  // After the loop's end: spools the rest as a last chunk. The attempt stays without an end and can be
  // resumed. Errors: the spool's.
  Status Flush();
  // After the loop's end: Flush, then the seal. Errors: the spool's; kInvalidInput when not one tick
  // was recorded.
  Result<trace::Seal> Finish();

  uint32_t chunks() const { return chunks_.load(std::memory_order_acquire); }
  uint64_t ticks() const { return ticks_.load(std::memory_order_acquire); }
  // Ticks in memory or in the ring, not in the spool yet; from any thread, approximate.
  uint64_t waiting_ticks() const { return held_.load(std::memory_order_acquire) + ring_.size(); }

 private:
  Status Spill();

  Spool& spool_;
  SampleRing& ring_;
  const Uuid attempt_;
  const trace::SecretKey key_;
  const size_t ticks_per_chunk_;
  std::vector<trace::Tick> open_;  // ticks of the chunk being filled
  Bytes unspooled_;                // an encoded chunk the spool did not take yet
  uint64_t state_hash_ = 0;
  uint64_t first_tick_ = 0;
  Sha256 previous_;
  std::atomic<uint32_t> chunks_{0};
  std::atomic<uint64_t> ticks_{0};
  std::atomic<size_t> held_{0};  // open_'s
};

}  // namespace enamel::station
