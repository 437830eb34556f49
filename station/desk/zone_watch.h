#pragma once

#include <optional>

#include "common/base/mutex.h"
#include "common/scoring/zones.h"
#include "station/render/panel.h"

namespace enamel::station::desk {

// How much of the exercise's zones is gone, while it is being cut: as the score will measure it
// (scoring::MeasureZone), a few times a second, on the mesher's thread.
// Thread safety: Look by one thread, shares from any.
class ZoneWatch {
 public:
  // `initial` outlives this. Without a target in the scene it knows nothing.
  ZoneWatch(const scene::Scene& scene, const scene::CavityTarget& target,
            const cutting::Volume& initial);

  void Look(const cutting::Volume& now);
  std::optional<render::ZoneShares> shares() const;

 private:
  const cutting::Volume& initial_;
  std::optional<scoring::ZoneBoxes> boxes_;  // its zones grown with the first look
  mutable Mutex mutex_;
  std::optional<render::ZoneShares> shares_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::station::desk
