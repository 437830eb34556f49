#pragma once

#include <optional>

#include "common/base/mutex.h"
#include "common/scoring/zones.h"
#include "station/render/panel.h"

namespace enamel::station::desk {

// Measures how much of the exercise's zones has been removed during the cut, as the score will
// (scoring::MeasureZone), a few times a second on the mesher's thread. Thread safety: Look by one
// thread, shares from any.
class ZoneWatch {
 public:
  // `initial` outlives this. Knows nothing if the scene has no target.
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
