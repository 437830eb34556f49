#include "server/storage/upkeep/readiness.h"

namespace enamel::server {

Readiness ReadinessOf(const StoreHealth& health, const std::optional<PeersView>& peers) {
  if (health.clock_is_off) return Readiness::kClockOff;
  if (!health.takes_recordings) {
    const bool all = !peers || (peers->answered > 0 && peers->database == peers->answered);
    return health.database_fails && all ? Readiness::kDegraded : Readiness::kNoRecordings;
  }
  // Chunks are taken without them, so a server that nobody can compare with stays.
  const bool alone = peers && ((health.blobs_fail && peers->blobs < peers->answered) ||
                               (health.keys_fail && peers->keys < peers->answered));
  if (alone) return Readiness::kNoRecordings;
  const bool well = health.clock_problem.empty() && health.waiting.empty();
  return well ? Readiness::kReady : Readiness::kDegraded;
}

}  // namespace enamel::server
