#include "station/desk/watch/zone_watch.h"

#include <algorithm>

#include "common/scoring/task.h"

namespace enamel::station::desk {

ZoneWatch::ZoneWatch(const scene::Scene& scene, const scene::CavityTarget& target,
                     const cutting::Volume& initial)
    : initial_(initial) {
  auto boxes = scoring::BoxesOf(scene, target);
  if (!boxes.ok() || target.depth_um == 0) return;
  boxes_ = *boxes;
  shares_ = render::ZoneShares{};
}

void ZoneWatch::Look(const cutting::Volume& now) {
  if (!boxes_) return;
  scoring::GrowZones(initial_, *boxes_);
  auto measure = [&](scoring::Zone zone) {
    return scoring::MeasureZone(initial_, now, *boxes_, zone);
  };
  const scoring::BoxVolume target = measure(scoring::Zone::kTarget);
  const scoring::BoxVolume leeway = measure(scoring::Zone::kLeeway);
  const auto removed = scoring::RemovedPerTissue_m3(initial_, now);
  auto percent = [](double part, double whole) {
    return whole > 0 ? std::clamp(100 * part / whole, 0.0, 100.0) : 0;
  };
  render::ZoneShares shares;
  shares.target_percent = percent(target.removed_m3, target.solid_m3);
  shares.leeway_percent =
      percent(leeway.removed_m3 - target.removed_m3, leeway.solid_m3 - target.solid_m3);
  shares.beyond_mm3 = std::max(0.0, scoring::Sum_m3(removed) - leeway.removed_m3) * 1e9;
  shares.neighbour_mm3 = removed[static_cast<size_t>(cutting::Tissue::kNeighbour)] * 1e9;
  MutexLock lock(mutex_);
  shares_ = shares;
}

std::optional<render::ZoneShares> ZoneWatch::shares() const {
  MutexLock lock(mutex_);
  return shares_;
}

}  // namespace enamel::station::desk
