#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "common/base/result.h"
#include "tests/load/stations/station.h"

namespace enamel::load {

// The server's stored attempts, compared byte by byte with the data sent.
struct ReadBack {
  uint64_t ticks_stored = 0;    // as sent, each once
  uint64_t ticks_lost = 0;      // committed and not stored as they were sent
  uint64_t ticks_doubled = 0;   // stored more than once, or never sent
  uint64_t damaged_chunks = 0;  // stored with other bytes
};

// `data`: the server's folder, opened while it runs. `progress`: 0 to 1.
Result<ReadBack> ReadEverythingBack(const std::filesystem::path& data,
                                    const std::vector<const Station*>& stations,
                                    const std::function<void(double)>& progress);

}  // namespace enamel::load
