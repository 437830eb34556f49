#pragma once

#include <array>
#include <cstdint>

#include "common/cutting/bur.h"
#include "common/cutting/tissue.h"
#include "common/math/vec.h"

namespace enamel::station::render {

// Reasons for the operator to look at the screen. Shown as text in the window.
enum Warning : uint32_t {
  kWarnForceBounded = 1u << 0,  // the law's force was cut to the device's limit
  kWarnLate = 1u << 1,          // ticks run late
  kWarnFault = 1u << 2,         // force is held at zero (TickLoop)
  kWarnGap = 1u << 3,           // ticks were just lost: not recorded, not stepped
  kWarnOffline = 1u << 4,       // server not reachable: recording continues on the station
  kWarnPulpExposed = 1u << 5,
  kWarnDisk = 1u << 6,         // the spool takes nothing at the moment
  kWarnDevice = 1u << 7,       // the device reports nothing new
  kWarnTime = 1u << 8,         // past the exercise's time limit
  kWarnResumed = 1u << 9,      // resumed after an interruption: no cause for alarm
  kWarnNoRealtime = 1u << 10,  // in place of kWarnLate, where the loop has no real-time rights
  kWarnSwing = 1u << 11,       // the device swung, and its stiffness is lowered (core::kSwingSeen)
};
inline constexpr int kWarningCount = 12;

// The picture's facts of one tick: a plain value, copied whole. Scene frame, SI.
struct FrameState {
  uint64_t tick = 0;
  double time_s = 0;           // of the attempt, for the timer
  cutting::Pose anchor;        // the bur as it cuts
  cutting::Pose device;        // where the hand is; drawn as a ghost when apart from the anchor
  dvec3 pressed_n{0};          // on the hand (core::TickOutput::pressed_n)
  double bur_speed_ratio = 1;  // of the spindle's free speed (core::TickOutput)
  bool bur_on = false;
  uint8_t bur = 0;         // the number of the bur in the handpiece
  bool bur_waits = false;  // another comes once this one is out of the tooth
  uint32_t warnings = 0;   // Warning bits
  std::array<double, cutting::kTissueCount> removed_mm3{};
};

}  // namespace enamel::station::render
