#pragma once

#include "common/timeline/player.h"
#include "common/timeline/start_tooth.h"

// The tooth at a moment with a fifteenth of the bytes, to be seen first (schemas/surface_timeline.md).
// Thread safety: functions, any thread. Not real-time.
namespace enamel::timeline {

inline constexpr int kCoarser = 4;  // times longer voxels

// The player's tooth as it is now, on a grid of its own. Errors: kInvalidInput when its voxels would
// be too long for one.
Result<StartTooth> CoarseTooth(const Player& player);

}  // namespace enamel::timeline
