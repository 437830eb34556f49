#pragma once

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/math/vec.h"

// Watches the sent force for a swing: hand and device pass energy to and fro because the device has less
// damping or friction, or a longer delay, than its profile says. Then Kc is too stiff for it.
//
// How a swing differs from everything else:
//  * Only the part of the force above kBand_hz counts (two high-pass stages of first order).
//  * A half cycle ends where that part turns against its own farthest point and passes least_n on the other
//    side. No axis of space is special.
//  * A half cycle is *kept* if it reaches kKept of the one two before it, on the same side; the first two
//    always are. The ring after an impact dies away; a swing grows or stays.
//  * half_cycles of them, each at most kLongest_s after the last, are a swing. One that is not kept
//    takes two off the count.
//
// From then on every kept half cycle lowers the share of the stiffness by kFall, down to kMinShare,
// until the swing has died away. The share never rises again: the device stays what it is.
//
// Feed it the coupling's force without touch cues: those oscillate on purpose. What it catches and
// misses: README.md, "A watch for swings".
//
// SI units. Thread safety: none, one loop owns it. Real-time: all but VisitState are safe (no
// allocation). Deterministic: + - * / sqrt.
namespace enamel::haptics {

// Origin of the constants: 372 swings and 3000 right hands on simulated plants that share nothing with the
// suite "watch" (README.md). tests/common/haptics/swing_watch_test.cpp notices each.
struct SwingWatchParams {
  double tick_s = 0.001;
  // Smaller alternations are not looked at, N. Lower: a strong tremor trips it. Higher: swings that
  // begin small are caught later.
  double least_n = 0.25;
  // More of them: later. Fewer: a hard tap trips it.
  int half_cycles = 6;
};

class SwingWatch {
 public:
  // Below the slowest swings of heavy hands (8 to 12 Hz on soft devices), above what hands do willingly.
  static constexpr double kBand_hz = 8;
  static constexpr double kKept = 0.92;
  static constexpr double kLongest_s = 0.07;
  // Of the share left, for each kept half cycle of a swing; reached at kFall_per_s, as a hand feels a step.
  static constexpr double kFall = 0.7, kFall_per_s = 16;
  // A third of the damping and an untold tick of delay need 1/12.
  static constexpr double kMinShare = 1.0 / 16;

  explicit SwingWatch(const SwingWatchParams& params);

  // Force is off, or the tip has moved unseen: what was under way is void. The share stays.
  void Forget() noexcept;
  // One tick. Returns the share of the stiffness to use from the next tick on, in [kMinShare, 1].
  // Requires: finite numbers.
  ENAMEL_REALTIME double Tick(const dvec3& force_n) noexcept;

  double share() const noexcept { return share_; }
  // A swing has been seen since construction.
  bool tripped() const noexcept { return wanted_ < 1; }
  // Saves or restores all that the next Tick depends on but the parameters.
  void VisitState(StateArchive& archive);

 private:
  dvec3 AboveBand(dvec3 force_n) noexcept;
  void Begin(const dvec3& at_n) noexcept;
  void EndHalfCycle() noexcept;

  SwingWatchParams params_;
  double low_pass_;  // share of a step that a stage follows in a tick
  dvec3 slow_[2] = {dvec3(0), dvec3(0)};
  // The half cycle under way: its farthest point and that point's length; 0: none.
  dvec3 farthest_{0};
  double length_n_ = 0, since_s_ = 0;
  double before_n_[2] = {0, 0};  // the two before it, older first; 0: none
  int count_ = 0;
  double share_ = 1, wanted_ = 1;
};

}  // namespace enamel::haptics
