#pragma once

#include "station/loop/tick_loop.h"
#include "station/render/tooth_view.h"

namespace enamel::station::desk {

// Decides which of an attempt's gaps the screen reports now. A gap while cutting is shown for
// kShown_s. While the force is still off since a gap, or since a fault that has ended, a calm notice
// replaces it until the bur has been in free air. The gap at which an interrupted attempt
// resumes gets that notice for kCalm_s at least. Pure; real-time.
class GapWatch {
 public:
  static constexpr double kShown_s = 8, kCalm_s = 4;

  explicit GapWatch(uint32_t rate_hz) : rate_hz_(rate_hz) {}
  // Call for each tick in turn. Returns kWarnGap, kWarnResumed or 0.
  ENAMEL_REALTIME uint32_t Look(const Snapshot& snapshot) noexcept;

 private:
  const double rate_hz_;
  bool started_ = false, resumed_ = false;
  bool off_ = false;                    // without force since a gap or a fault
  uint64_t gap_ticks_ = 0, since_ = 0;  // stepped ticks at the last gap
};

// Shows each tick in a tooth's view. Real-time. Thread safety: as TickObserver. The view outlives
// it.
class TickFeed final : public TickObserver {
 public:
  TickFeed(render::ToothView& view, double voxel_m, uint32_t rate_hz)
      : view_(view), voxel_m_(voxel_m), tick_s_(1.0 / rate_hz), gaps_(rate_hz) {}

  ENAMEL_REALTIME void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;

 private:
  render::ToothView& view_;
  const double voxel_m_;
  const double tick_s_;
  GapWatch gaps_;
};

}  // namespace enamel::station::desk
