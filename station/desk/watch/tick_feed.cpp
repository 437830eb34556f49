#include "station/desk/watch/tick_feed.h"

namespace enamel::station::desk {
namespace {

uint32_t WarningsOf(const Snapshot& s) noexcept {
  uint32_t warnings = 0;
  if (s.output_flags & haptics::kPeakBounded) warnings |= render::kWarnForceBounded;
  if (s.output_flags & core::kSwingSeen) warnings |= render::kWarnSwing;
  if (s.input_flags & core::kLateTick) warnings |= render::kWarnLate;
  if (s.input_flags & core::kFaulted) warnings |= render::kWarnFault;
  if (s.fault == Fault::kStalled || s.fault == Fault::kUnplugged ||
      s.fault == Fault::kSwitchedOff) {
    warnings |= render::kWarnDevice;
  }
  if (s.removed[static_cast<size_t>(cutting::Tissue::kPulp)] > 0) {
    warnings |= render::kWarnPulpExposed;
  }
  return warnings;
}

}  // namespace

uint32_t GapWatch::Look(const Snapshot& s) noexcept {
  const uint64_t gaps = s.counters.gap_ticks, ticks = s.counters.ticks;
  if (!started_ || gaps != gap_ticks_) {
    resumed_ = !started_ && gaps > 0;
    started_ = true;
    gap_ticks_ = gaps;
    since_ = ticks;
    off_ = gaps > 0;
  }
  const bool faulted = s.fault != Fault::kNone;
  off_ = (off_ || faulted) && (s.output_flags & core::kSuspended) != 0;
  // A fault has a text of its own, as long as it lasts. The force may stay off for longer.
  const bool told = off_ && !faulted;
  if (gaps == 0) return told ? uint32_t{render::kWarnResumed} : 0;
  bool recent = static_cast<double>(ticks - since_) < (resumed_ ? kCalm_s : kShown_s) * rate_hz_;
  if (told || (resumed_ && recent)) return render::kWarnResumed;
  resumed_ = false;
  return recent ? uint32_t{render::kWarnGap} : 0;
}

void TickFeed::OnTick(const core::Core& core, const Snapshot& s) noexcept {
  render::FrameState frame;
  frame.tick = s.counters.ticks;
  frame.time_s = static_cast<double>(s.counters.passed_ticks()) * tick_s_;
  frame.anchor = s.anchor;
  frame.device = s.device;
  frame.pressed_n = s.pressed_n;
  frame.bur_speed_ratio = s.bur_speed_ratio;
  frame.bur_on = (s.input_flags & core::kBurOn) != 0;
  frame.bur = s.bur;
  frame.bur_waits = s.bur_waits;
  frame.warnings = WarningsOf(s) | gaps_.Look(s);
  for (size_t t = 0; t < frame.removed_mm3.size(); ++t) {
    frame.removed_mm3[t] = cutting::RemovedUnitsToM3(s.removed[t], voxel_m_) * 1e9;
  }
  view_.Publish(frame);
  view_.PublishBricks(core.volume(), core.touched());
}

}  // namespace enamel::station::desk
