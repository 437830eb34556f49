#pragma once

#include "station/loop/tick_loop.h"
#include "station/render/tooth_view.h"

namespace enamel::station::desk {

// Shows each tick in a tooth's view. Real-time. Thread safety: as TickObserver. The view outlives
// it.
class TickFeed final : public TickObserver {
 public:
  TickFeed(render::ToothView& view, double voxel_m, uint32_t rate_hz)
      : view_(view), voxel_m_(voxel_m), tick_s_(1.0 / rate_hz) {}

  ENAMEL_REALTIME void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;

 private:
  render::ToothView& view_;
  const double voxel_m_;
  const double tick_s_;
};

}  // namespace enamel::station::desk
