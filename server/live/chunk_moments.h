#pragma once

#include <vector>

#include "common/trace/trace.h"
#include "server/live/live_board.h"

namespace enamel::server {

// A chunk as viewers see it: LiveBoard::kRowsPerSecond moments for each second, the chunk's newest
// among them. Pure function, any thread.
std::vector<LiveSample> MomentsOf(const trace::Chunk& chunk, const Uuid& station,
                                  UnixMs received_ms);

}  // namespace enamel::server
