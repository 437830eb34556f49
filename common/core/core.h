#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/base/state_hash.h"
#include "common/core/handpiece.h"
#include "common/core/params.h"
#include "common/cutting/cutter.h"
#include "common/cutting/engagement.h"
#include "common/cutting/sweep.h"
#include "common/cutting/volume.h"
#include "common/haptics/coupling.h"
#include "common/haptics/touch_cues.h"
#include "common/haptics/turning.h"
#include "common/math/orientation.h"

// The deterministic core: quantised pose in; force, anchor, tooth and state hash out.
namespace enamel::core {

// The report of device and loop about a tick. Recorded, so that a replay gets the same.
enum InputFlags : uint8_t {
  kBurOn = 1 << 0,     // pedal down: the bur turns
  kLateTick = 1 << 1,  // this tick ran late (recorded; the maths does not read the clock)
  kFaulted = 1 << 2,  // force is held at zero until the station ends it in free air; nothing is cut
  kSoftRestart = 1 << 3,  // switch force and cutting off until the bur has been in free air again
  // The gap's ticks passed while the loop was late: the device held the force of the tick before,
  // for less than 5 ms (station/loop/tick_loop.h; what that can leak: haptics/README.md, "Late and
  // lost ticks"). Time passed, and nothing else is to be made up for.
  kHeldGap = 1 << 4,
};
// The three bits above are the number of the bur in the handpiece (CoreParams::other_burs).
inline constexpr int kBurShift = 5;
constexpr size_t BurIn(uint8_t flags) noexcept { return size_t{flags} >> kBurShift; }
constexpr uint8_t BurFlags(size_t bur) noexcept { return static_cast<uint8_t>(bur << kBurShift); }

// One tick's input: the truth of a recording. Everything else is computed.
struct TickInput {
  std::array<int32_t, 3> counts{};  // device counts (CoreParams::resolution_nm)
  QuantisedOrientation orientation = kIdentityOrientation;
  uint8_t flags = 0;  // InputFlags, and the bur
  uint16_t bur_speed_krpm = 0;
  // Ticks that passed without being recorded, and so without being stepped, before this one.
  uint32_t gap_ticks = 0;
  // What the board's spring reports (CoreParams::spring_on_board): how far its rest point lies from
  // where the core expects it (Core::RestOff_nm), and what is missing of the share of the stiffness
  // that is felt, 1/65535. 0 in nearly every tick: the guard lets the rest point go where it should.
  std::array<int32_t, 3> rest_off_nm{};
  uint16_t share_lost = 0;

  bool operator==(const TickInput&) const = default;
};

// What the board's spring is to do next.
struct SpringWish {
  bool on = false;  // off: at rest at the tip, no force
  bool follow =
      false;  // nothing solid is near: the board keeps the rest point at the tip by itself
  // From where the counts are 0, scene axes; rounded to the nearest, halves away from 0.
  std::array<int32_t, 3> rest_nm{};
};

// The core's output at the resolution of the recording: the witness of a tick. Finer than any device
// sends a force or a reading moves the tip, and what is beyond it is in the state's hash.
struct TickWitness {
  // On the operator, mN: to the motors; and what the hand is to feel, before the bounds, the device's
  // own friction among it (haptics::CouplingOutput).
  std::array<int32_t, 3> force_sent_mn{};
  std::array<int32_t, 3> force_computed_mn{};
  std::array<int32_t, 3> anchor_100nm{};  // relative to CoreParams::device_origin_nm
  uint16_t flags = 0;                     // haptics::CouplingFlags | OutputFlags

  bool operator==(const TickWitness&) const = default;
};

enum OutputFlags : uint16_t {
  kAnchorReset = 1 << 8,       // after a gap, a fault or at the start
  kReserveExhausted = 1 << 9,  // the cut is incomplete; cannot be (Volume::Reserve), stays taken
  kSuspended = 1 << 10,  // no force and no cut: the bur has not yet been in free air long enough
  kStepTooLong =
      1 << 11,  // a fault: the bur would have moved by more than kMaxPosesPerMove cuts at once
  // Hand and device have swung in this attempt, and the stiffness is lowered to its end: the device
  // is not what its profile says (haptics/swing_watch.h).
  kSwingSeen = 1 << 12,
};

// The force that tissue and hand press each other with, mN: the force computed, or what a bound has left
// of it. Without touch cues, and the same on a device with much friction and with none: the hand overcomes the
// friction that the motors leave out. Where c was measured, soft tissue meets a softer spring, and the bur lags more.
inline const std::array<int32_t, 3>& PressedForce_mn(const TickWitness& witness) noexcept {
  return (witness.flags & haptics::kPeakBounded) != 0 ? witness.force_sent_mn
                                                      : witness.force_computed_mn;
}

struct TickOutput {
  dvec3 force_sent_n{0};  // to send to the device, scene frame; the touch cue is in it
  dvec3 cue_n{0};         // none in a tick whose force a bound has changed
  dvec3 force_computed_n{0};
  // The same force as PressedForce_mn, not rounded.
  const dvec3& pressed_n() const noexcept {
    return (flags & haptics::kPeakBounded) != 0 ? force_sent_n : force_computed_n;
  }
  dvec3 torque_sent_n_m{0};         // on the operator, scene frame; 0 without peak_torque_un_m
  cutting::Pose anchor;             // the bur as drawn and as it cuts
  cutting::RemovedUnits removed{};  // by this tick, per tissue, 1/65536 voxel
  SpringWish spring;                // if the spring is on the board; else off
  double bur_speed_ratio = 1;       // the handpiece's speed, as a share of its free speed
  uint16_t flags = 0;
  TickWitness witness;
};

// A pure function of (params, initial volume, inputs so far): same tooth, same forces, same hash,
// to the last bit, on every compiler and machine this builds on. No clock, no randomness, no libm.
//
// Force and cutting are switched on in free air only. At the start, after a fault and after a gap
// in which the hand moved by more than half a voxel, the tip's way is unknown. Putting the anchor
// at the tip would cut a hole of the bur's size at no force. Leaving it behind would hand out
// energy that nobody put in. So the anchor stays at the tip, without force or cut, until the bur
// has touched nothing for soft_start_ticks (kSuspended). After a shorter gap the cut continues from
// where it was (Coupling::Resume). A gap over which the force was held (kHeldGap) belongs to a late
// tick: the next tick is stepped like any other, and the gap is only time.
//
// The bur is changed in the tick whose flags name another: what the one before has passed is cut,
// and force and cutting are switched off as after a fault, until the new one has been in free air.
// A number that no bur has is a fault in each tick that names it, and changes nothing else.
//
// Order in a tick: read p; engagement at the anchor; law moves the anchor (through contact, in
// steps of at most half a voxel) and cuts along it; bounds; hash. A step through open air stops at
// the first contact, and the rest of the tick is spent in the tissue found there
// (haptics/coupling.h). A tick's last cut is done in two halves, the second at the beginning of the
// next tick. Touch cues (haptics/touch_cues.h) are added last, to the force sent alone: nothing
// else feels them.
//
// Torque (CoreParams::peak_torque_un_m above 0): a spring between the device's orientation and the
// bur's, whose every turn is a guarded one (haptics/turning.h). Its resistance comes from the same
// engagement as the force's: only a turn into solid resists. A still bur and the shank do not turn
// into solid. Torque is 0 wherever force is switched off. After a short gap it stays off until the
// hand has turned back to the bur. If the bur's far end would have to move by more than half a
// voxel to follow, the core is suspended as after a jump. The state hash covers torque; the witness
// has no field for it.
//
// Work in a tick is bounded: at most kMaxMovesPerTick moves of the anchor, each with one engagement
// sample, and kMaxCutsPerTick cuts of at most Cutter::MaxBricks bricks. The laws that take the bur
// to the tip do so in one move of at most kMaxPosesPerMove poses. A longer move (6.4 mm a tick at
// 0.05 mm) cuts nothing, is flagged kStepTooLong and suspends. Ordinary motion cuts half a pose a
// tick; a tick near the bound takes milliseconds, and is then late. The hole lags behind a moving
// bur by at most Sweep::SpanOf (cutting/sweep.h) and a tick. The rest is cut when the bur stops,
// turns, is switched off or suspended.
//
// Thread safety: none. Real-time: Step is safe (no allocation, bounded work); construction is not.
class Core {
 public:
  // Requires: ValidateParams(params).ok().
  Core(const CoreParams& params, cutting::Volume initial);
  ~Core();
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  static constexpr int kMaxMovesPerTick = 300, kMaxPosesPerMove = 256;
  // A pose is cut once at most: those of the moves, and what waited before.
  static constexpr int kMaxCutsPerTick =
      kMaxMovesPerTick + kMaxPosesPerMove + static_cast<int>(cutting::Sweep::kMaxDue);

  ENAMEL_REALTIME TickOutput Step(const TickInput& input) noexcept;

  // Hash of all scalars and, in a fixed schedule of at most 8 bricks per tick, of every brick that
  // changed. Two runs that differ anywhere differ here within dirty bricks / 8 ticks.
  uint64_t state_hash() const noexcept { return hash_.value(); }
  uint64_t ticks() const noexcept { return ticks_; }
  const cutting::Volume& volume() const noexcept { return volume_; }
  // The number of the bur in the handpiece.
  size_t bur() const noexcept { return bur_; }
  // Whether a change of it would be felt by nobody: force is off, or no solid is near bur and shank (by bricks: a bur
  // nearer than some 12 voxels may count as in the tooth). Real-time: safe.
  ENAMEL_REALTIME bool OutOfTooth() const noexcept {
    return suspended_ || !cutter_.AnySolidNear({coupling_.anchor_m(), orientation_}, 0);
  }
  const CoreParams& params() const noexcept { return params_; }
  // Removed since the start, per tissue, 1/65536 voxel.
  const cutting::RemovedUnits& removed() const noexcept { return removed_; }
  // Work of the last Step, for the bound above.
  struct Work {
    int moves = 0, cuts = 0, bricks = 0, samples = 0;
  };
  const Work& work() const noexcept { return work_; }
  // Bricks changed by the last Step; valid until the next.
  std::span<const int32_t> touched() const noexcept { return {touched_.data(), touched_count_}; }
  // Tip position of device counts, scene frame, metres.
  dvec3 TipOf(const std::array<int32_t, 3>& counts) const noexcept;

  // TickInput::rest_off_nm of the next Step, for a rest point that the board reports with `counts`, nm from
  // where the counts are 0, scene axes. The core expects it where the wish wanted it that was sent 1 +
  // bus_delay_ticks ticks before; at the tip, if that was off or to follow. Real-time: safe.
  ENAMEL_REALTIME std::array<int32_t, 3> RestOff_nm(
      const std::array<int32_t, 3>& counts, const std::array<int32_t, 3>& rest_nm) const noexcept;

  // Keyframes of a replay (trace/keyframes.h). VisitState saves or restores all that the next Step
  // depends on but the tooth's samples; RestoreBrick puts those back, brick by brick, into a core
  // made with the same parameters and initial volume. Saved bytes are this build's own. Restoring:
  // false when they are not such a core's; then the core must not be stepped. Not real-time.
  bool VisitState(StateArchive& archive);
  // False when the brick can never have been stored: outside the grid, or air from the start.
  bool RestoreBrick(int brick, std::span<const int16_t, cutting::kBrickVoxels> phi);

 private:
  class TissueMaterial;
  class TurnedMaterial;

  std::array<int64_t, 3> ExpectedRest_nm(const std::array<int32_t, 3>& counts) const noexcept;
  dvec3 PlaceOf(const std::array<int64_t, 3>& nm) const noexcept;
  void TakeSpring(const TickInput& input, TickOutput& out) noexcept;
  cutting::EngagementReader& engagement() noexcept { return engagements_[bur_]; }
  void UseBur(size_t bur) noexcept;
  void Suspend(const dvec3& tip_m, const Quat& orientation) noexcept;
  void FollowTip(const dvec3& tip_m, const Quat& orientation) noexcept;
  void AwaitFreeAir(const dvec3& tip_m, const Quat& orientation) noexcept;
  bool ResumeAfterGap(const dvec3& tip_m, const Quat& device) noexcept;
  dvec3 FeelTurning(const Quat& device, TissueMaterial& material) noexcept;
  void FollowOrientation(const Quat& device, TissueMaterial& material) noexcept;
  dvec3 RotationalStretch(const dvec3& e_rad, double dt_s) noexcept;
  void ReadContact(const cutting::Pose& pose) noexcept;
  void CutPoses(std::span<const cutting::Pose> due) noexcept;
  void CutRest() noexcept;
  void AddCue(const TickInput& input, const dvec3& tip_m, bool unfelt, TickOutput& out) noexcept;
  void Booked(bool complete) noexcept;
  void FinishCut() noexcept;
  void MarkTouched(int32_t brick) noexcept;
  void FoldHash(const TickInput& input, const TickOutput& out) noexcept;

  const CoreParams params_;
  cutting::Volume volume_;
  cutting::Cutter cutter_;
  const double reach_m_;  // of the longest bur and its shank, from the tip
  cutting::Sweep sweep_;
  std::vector<cutting::EngagementReader> engagements_;  // one for each bur
  size_t bur_ = 0;                                      // the one in the handpiece
  haptics::Coupling coupling_;
  const bool torque_;  // on this device
  haptics::Turning turning_;
  // The newest wishes, by tick: as many as the longest bus_delay_ticks needs.
  static constexpr size_t kWishes = 17;
  std::array<SpringWish, kWishes> wishes_{};
  Handpiece handpiece_;
  haptics::TouchCues cues_;
  // The material's answers in this tick, for the cues: B is the touched tissue's own.
  struct Touched {
    bool read = false, engaged = false;
    double b_n_s_per_m = 0;
  };
  Touched tissue_;
  Quat orientation_;  // the anchor's
  bool started_ = false;
  bool bur_on_ = false;
  bool suspended_ = true;
  uint32_t free_ticks_ = 0;  // in a row, while suspended
  cutting::RemovedUnits removed_{};
  StateHash hash_;
  uint64_t ticks_ = 0;

  // Pose of the last engagement sample, renewed when the anchor has moved by an eighth of a voxel.
  // A cut alone does not change it: it removes tissue inside the bur, which weighs no more than
  // tissue at the bur's surface.
  cutting::Pose sampled_;
  bool sample_valid_ = false;
  cutting::Pose half_cut_;  // the pose whose upper half waits for the next tick
  bool has_half_cut_ = false;
  bool step_too_long_ = false;
  double resisting_n_ = 0;  // |R| of the last tick
  double drag_n_m_ = 0;     // on the spindle in the last tick, from tissue that has a friction
  Work work_;
  bool reserve_exhausted_ = false;

  // Changed bricks waiting to be hashed: ring with one entry per brick at most.
  std::vector<int32_t> dirty_ring_;
  std::vector<uint8_t> is_dirty_;
  size_t dirty_head_ = 0, dirty_count_ = 0;
  // Bricks touched in this tick.
  std::vector<int32_t> touched_;
  std::vector<uint8_t> is_touched_;
  size_t touched_count_ = 0;
};

}  // namespace enamel::core
