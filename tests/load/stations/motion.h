#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"

namespace enamel::load {

// A recorded movement with its forces, tick by tick, the source of all stations' streams.
struct Motion {
  std::vector<trace::Tick> ticks;
  std::array<int32_t, 3> resolution_nm{};
};

// A class I cavity cut by station::lab::RecordAttempt: `ticks` at 1 kHz.
Result<Motion> SimulatedMotion(uint64_t ticks, const std::function<void(double)>& progress = {});
// A trace file (`enamel-station spool export`).
Result<Motion> ReadMotion(const std::filesystem::path& file);

// The content of one chunk, encoded and packed as by a station, not yet placed in a chain.
struct Payload {
  uint32_t count = 0, gap_ticks = 0, unpacked_size = 0;
  Bytes packed;
};

// `chunks` consecutive chunks of `chunk_ticks` ticks of station number `station`: the motion from
// the station's own start, around its end, shifted in space by the station's own offset, so that no
// two stations send the same ticks. Pure function; about 0.3 ms per 500 ticks.
std::vector<Payload> StreamOf(const Motion& motion, size_t station, size_t chunk_ticks,
                              size_t chunks);

}  // namespace enamel::load
