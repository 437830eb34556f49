#include "common/core/core.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "common/core/quantise.h"
#include "common/math/order.h"

namespace enamel::core {
namespace {

using cutting::kTissueCount;
using cutting::Pose;

// A point's share of area falls from 1 to 0 over half a voxel (engagement.h): a reading this old is
// off by a quarter of it at most. cutting/README.md has the cost of reading in every tick. Another
// value moves forces, and so the golden recordings (tests/common/trace/golden_test.cpp).
constexpr double kSampleVoxels = 1.0 / 8;
// 8 KiB a tick. More would show a difference sooner and cost each tick more; it is part of what the
// hash means, so another number is another core version.
constexpr int kHashedBricksPerTick = 8;
// Enamel is some 0.016 N m s (haptics/README.md, "Torque": 20 ms on 0.8 N m/rad). Finite, so that
// it can be added to and solved with like any other B.
constexpr double kWallRotational_n_m_s = 1e3;  // a still bur in contact does not turn
// Area ahead of a turn below which a wall does not block it: what rounding leaves of a turn along
// the wall is not one into it.
constexpr double kWallArea_m2 = 1e-12;

// Of the longest of its burs: a bound for each.
double ReachOf(const CoreParams& p) {
  double reach_m = 0;
  for (const cutting::Bur& bur : BursOf(p)) {
    double shank =
        bur.shank_radius_m > 0 ? bur.neck_m + bur.shank_radius_m + cutting::kShankLength_m : 0;
    reach_m = HigherOf(reach_m, bur.radius_m + bur.height_m() + shank);
  }
  return reach_m;
}

cutting::TissueDamping DampingOf(const CoreParams& p) {
  cutting::TissueDamping out;
  // 1 mN s/mm = 1 N s/m.
  for (size_t t = 0; t < kTissueCount; ++t) {
    out.lateral[t] = p.damping_mn_s_per_mm[t];
    int32_t axial = p.axial_damping_mn_s_per_mm[t];
    out.axial[t] = axial > 0 ? axial : p.damping_mn_s_per_mm[t];
    out.coulomb_n[t] = p.coulomb_mn[t] * 1e-3;
    out.exponent[t] = p.feed_exponent[t];
    out.feed_m_per_s[t] = p.feed_um_per_s[t] * 1e-6;
    out.friction[t] = p.bur_friction_permille[t] * 1e-3;
  }
  return out;
}

haptics::CouplingParams CouplingOf(const CoreParams& p, double voxel_m) {
  haptics::CouplingParams c;
  c.law.kind = p.law;
  c.law.kc_n_per_m = p.kc_mn_per_mm;
  c.law.resolution_m = dvec3(p.resolution_nm[0], p.resolution_nm[1], p.resolution_nm[2]) * 1e-9;
  c.law.tick_s = 1.0 / p.rate_hz;
  c.law.pass_through_at_rest = p.pass_through_at_rest;
  c.peak_force_n = p.peak_force_mn * 1e-3;
  c.delay_ticks = static_cast<int>(p.bus_delay_ticks);
  c.max_step_m = 0.5 * voxel_m;
  c.cell = TipCellOf(p);
  c.friction = OwnFrictionOf(p);
  c.spring_on_board = p.spring_on_board;
  // Nobody swings with a device that has no motors. Its friction is 0 here, and no other device's: c >= Kc S.
  c.watch_swings = p.friction_mn != std::array<int32_t, 3>{};
  return c;
}

haptics::TouchCueParams CuesOf(const CoreParams& p) {
  haptics::TouchCueParams c;
  c.contact_n = p.contact_cue_mn * 1e-3;
  c.chatter_n = p.chatter_cue_mn * 1e-3;
  c.peak_force_n = p.peak_force_mn * 1e-3;
  c.account.energy_j = p.cue_energy_nj * 1e-9;
  c.account.power_w = p.cue_power_nw * 1e-9;
  c.account.tick_s = 1.0 / p.rate_hz;
  const haptics::TipCell cell = TipCellOf(p);
  c.account.cell_half_m = cell.half_m + dvec3(cell.ball_m);
  c.account.delay_ticks = static_cast<int>(p.bus_delay_ticks);
  return c;
}

haptics::TurningParams TurningOf(const CoreParams& p, double voxel_m) {
  haptics::TurningParams t;
  t.k_n_m_per_rad = p.rotational_kc_un_m_per_rad * 1e-6;
  t.peak_n_m = p.peak_torque_un_m * 1e-6;
  t.cell_rad = p.rotation_cell_urad * 1e-6;
  t.tick_s = 1.0 / p.rate_hz;
  t.delay_ticks = static_cast<int>(p.bus_delay_ticks);
  t.max_turn_rad = 0.5 * voxel_m / ReachOf(p);
  return t;
}

}  // namespace

// The volume as the coupling sees it.
class Core::TissueMaterial final : public haptics::Material {
 public:
  explicit TissueMaterial(Core& core) : core_(core) {}

  haptics::Contact ContactAt(const dvec3& anchor_m, const dvec3& stretch_m) noexcept override {
    Pose pose{anchor_m, core_.orientation_};
    haptics::Contact contact;
    core_.tissue_.read = true;
    double travel = std::sqrt(Dot(stretch_m, stretch_m));
    // Look as far ahead as the move itself: no solid there, no contact on the way.
    double voxel = core_.volume_.spec().voxel_m();
    if (!core_.cutter_.AnySolidNear(pose, travel + voxel)) {
      contact.clearance_m = travel;
      core_.sample_valid_ = false;
      return contact;
    }
    core_.ReadContact(pose);
    if (!core_.engagement().MayTouch()) return contact;
    cutting::Engagement engagement = core_.engagement().Read(core_.volume_, stretch_m);
    contact.engaged = engagement.area_m2 > 0;
    if (contact.engaged && core_.cues_.enabled()) {
      core_.tissue_.engaged = true;
      // The press directions are of length 1, so the trace is the sum of beta dA: over the area it
      // is the touched tissue's own B, however little of the bur touches.
      core_.tissue_.b_n_s_per_m = engagement.damping_n_s_per_m.Trace() *
                                  cutting::EngagementReader::kReferenceArea_m2 / engagement.area_m2;
    }
    if (core_.bur_on_) {
      contact.damping_n_s_per_m =
          engagement.damping_n_s_per_m * (1 / core_.handpiece_.speed_ratio());
      contact.by_load = engagement.by_load;
      contact.wall_normal = engagement.shank_normal;
    } else {
      // All that a still bur touches is wall.
      contact.wall_normal = engagement.mean_normal;
    }
    return contact;
  }

  Sym3 SecantAt(const dvec3& feed_m_per_s) noexcept override {
    return core_.engagement().Secant(feed_m_per_s, core_.handpiece_.speed_ratio());
  }

  FeedForce ForceAlong(const dvec3& direction) noexcept override {
    return core_.engagement().Along(direction, core_.handpiece_.speed_ratio());
  }

  dvec3 DragAt(const dvec3& feed_m_per_s) noexcept override {
    const cutting::BurDrag drag =
        core_.engagement().Drag(feed_m_per_s, core_.handpiece_.speed_ratio());
    core_.drag_n_m_ = drag.torque_n_m;
    return drag.force_n;
  }

  void AnchorMoved(const dvec3& from_m, const dvec3& to_m) noexcept override {
    ++core_.work_.moves;
    if (!core_.bur_on_ || core_.step_too_long_) return;
    // Tip laws and open-air steps may move far at once: poses half a voxel apart.
    const double step = 0.5 * core_.volume_.spec().voxel_m();
    const dvec3 d = to_m - from_m;
    const double length = std::sqrt(Dot(d, d));
    // A long way with nothing solid in reach is flown. The sweep must not join its two ends by a
    // straight cut, so what the bur has passed before is cut now.
    if (length > step &&
        !core_.cutter_.AnySolidNear({from_m, core_.orientation_}, length + 2 * step)) {
      core_.FinishCut();
      return;
    }
    if (length > step * kMaxPosesPerMove) {
      core_.step_too_long_ = true;
      return;
    }
    const int poses = length > step ? static_cast<int>(length / step) + 1 : 1;
    for (int i = 1; i <= poses; ++i) {
      dvec3 at = i == poses ? to_m : from_m + d * (static_cast<double>(i) / poses);
      core_.CutPoses(core_.sweep_.Move({at, core_.orientation_}));
    }
  }

 private:
  Core& core_;
};

// The same for a bur that turns about its tip.
class Core::TurnedMaterial final : public haptics::TurnMaterial {
 public:
  TurnedMaterial(Core& core, TissueMaterial& tissue) : core_(core), tissue_(tissue) {}

  haptics::TurnContact ContactAt(const Quat& bur, const dvec3& turn_rad) noexcept override {
    const Pose pose{core_.coupling_.anchor_m(), bur};
    const double turn = std::sqrt(Dot(turn_rad, turn_rad));
    const double voxel = core_.volume_.spec().voxel_m();
    haptics::TurnContact contact;
    // The turn's sweep is within the bur's own reach.
    if (!core_.cutter_.AnySolidNear(pose, turn * core_.reach_m_ + voxel)) {
      contact.clear_rad = turn;
      core_.sample_valid_ = false;
      return contact;
    }
    // Solid within the turn but not here: no resistance yet, and no leave to turn all of it at
    // once.
    if (!core_.cutter_.AnySolidNear(pose, voxel)) return contact;
    core_.ReadContact(pose);
    if (!core_.engagement().MayTouch()) return contact;
    const cutting::RotationalEngagement ahead =
        core_.engagement().ReadRotational(core_.volume_, turn_rad);
    const double blocked_m2 = core_.bur_on_ ? ahead.shank_area_m2 : ahead.area_m2;
    if (blocked_m2 > kWallArea_m2) {
      contact.damping_n_m_s = Sym3::Isotropic(kWallRotational_n_m_s);
    } else if (core_.bur_on_) {
      contact.damping_n_m_s = ahead.damping_n_m_s * (1 / core_.handpiece_.speed_ratio());
    }
    return contact;
  }

  void BurTurned(const Quat& bur, bool far) noexcept override {
    core_.orientation_ = bur;
    if (far) {
      core_.FinishCut();
    } else {
      tissue_.AnchorMoved(core_.coupling_.anchor_m(), core_.coupling_.anchor_m());
    }
  }

 private:
  Core& core_;
  TissueMaterial& tissue_;
};

Core::Core(const CoreParams& params, cutting::Volume initial)
    : params_(params),
      volume_(std::move(initial)),
      // Before anything holds the volume: no cut allocates from here on.
      cutter_((volume_.Reserve(), volume_), BursOf(params)),
      reach_m_(ReachOf(params)),
      sweep_(volume_.spec().voxel_m(), reach_m_),
      coupling_(CouplingOf(params, volume_.spec().voxel_m())),
      torque_(params.peak_torque_un_m > 0),
      turning_(TurningOf(params, volume_.spec().voxel_m())),
      handpiece_(params),
      cues_(CuesOf(params)) {
  ENAMEL_CHECK(ValidateParams(params).ok());
  for (const cutting::Bur& bur : BursOf(params)) {
    engagements_.emplace_back(bur, volume_.spec().voxel_m(), DampingOf(params));
  }
  auto bricks = static_cast<size_t>(volume_.spec().brick_count());
  dirty_ring_.resize(bricks);
  is_dirty_.resize(bricks);
  touched_.resize(bricks);
  is_touched_.resize(bricks);
}

Core::~Core() = default;

void Core::UseBur(size_t bur) noexcept {
  bur_ = bur;
  cutter_.Use(bur);
  // It has read nothing while another bur cut.
  engagement().Forget();
  sample_valid_ = false;
}

void Core::Suspend(const dvec3& tip_m, const Quat& orientation) noexcept {
  suspended_ = true;
  free_ticks_ = 0;
  FollowTip(tip_m, orientation);
}

void Core::FollowTip(const dvec3& tip_m, const Quat& orientation) noexcept {
  FinishCut();
  coupling_.Reset(tip_m);
  orientation_ = orientation;
  if (torque_) turning_.Reset(orientation);
  sample_valid_ = false;
}

void Core::AwaitFreeAir(const dvec3& tip_m, const Quat& orientation) noexcept {
  FollowTip(tip_m, orientation);
  Pose pose{tip_m, orientation};
  bool touches = false;
  if (cutter_.AnySolidNear(pose, volume_.spec().voxel_m())) {
    engagement().Sample(volume_, pose);
    touches = engagement().Touches(volume_);
  }
  free_ticks_ = touches ? 0 : free_ticks_ + 1;
  // With soft_start_ticks = 0 too it takes one tick that touches nothing.
  suspended_ = touches || free_ticks_ < params_.soft_start_ticks;
}

bool Core::ResumeAfterGap(const dvec3& tip_m, const Quat& device) noexcept {
  TissueMaterial material(*this);
  // Asked before anything moves: coupling_.Resume cuts, and a refusal after that would come too
  // late.
  if (torque_ && !turning_.CanResume(device)) return false;
  if (!coupling_.Resume(tip_m, material)) return false;
  if (torque_) {
    TurnedMaterial turned(*this, material);
    turning_.Resume(device, turned);
  }
  return true;
}

dvec3 Core::FeelTurning(const Quat& device, TissueMaterial& material) noexcept {
  TurnedMaterial turned(*this, material);
  return turning_.Tick(device, turned);
}

// The anchor's orientation follows the device's through the same coupling as its position, felt or
// not: the angular stretch e relaxes as B_rot (B_rot + K_rot T I)^-1 e. Small-angle form, e = 2
// sign(w) v of the error quaternion: no libm. In air (B_rot = 0) the anchor's orientation is the
// device's. No point of the bur moves more than half a voxel before contact is read again, so a
// turn stops at the first contact and the rest of the tick is spent against its resistance.
void Core::FollowOrientation(const Quat& device, TissueMaterial& material) noexcept {
  if (RotationalKc_un_m_per_rad(params_, bur_) == 0) return;
  const double voxel = volume_.spec().voxel_m();
  double left_s = 1.0 / params_.rate_hz;
  for (int i = 0; i < haptics::Turning::kMaxTurns; ++i) {
    Quat error = device * orientation_.Conjugate();
    double sign = error.w < 0 ? -2 : 2;
    dvec3 e(error.x * sign, error.y * sign, error.z * sign);
    if (Dot(e, e) == 0) return;
    dvec3 move = e - RotationalStretch(e, left_s);
    double length = std::sqrt(Dot(move, move)), limit = 0.5 * voxel / reach_m_;
    bool whole = length <= limit;
    if (!whole) move *= limit / length;
    orientation_ = (Quat{0.5 * move.x, 0.5 * move.y, 0.5 * move.z, 1} * orientation_).Normalised();
    if (whole) return;  // Step reports it together with the tick's move
    material.AnchorMoved(coupling_.anchor_m(), coupling_.anchor_m());
    left_s -= left_s * (limit / length);
  }
}

dvec3 Core::RotationalStretch(const dvec3& e, double dt_s) noexcept {
  Pose pose{coupling_.anchor_m(), orientation_};
  if (!cutter_.AnySolidNear(pose, volume_.spec().voxel_m())) return dvec3(0);
  ReadContact(pose);
  if (!engagement().MayTouch()) return dvec3(0);
  // A still bur, or a shank at a wall, does not turn.
  const cutting::RotationalEngagement turning = engagement().ReadRotational(volume_, e);
  // B e' = -K e by implicit Euler: (B + K T) e1 = B e0. Stable for any B, 0 among them, and never
  // past the device's orientation.
  Sym3 b = bur_on_ && !turning.shank ? turning.damping_n_m_s * (1 / handpiece_.speed_ratio())
                                     : Sym3::Isotropic(kWallRotational_n_m_s);
  return b * SolveShifted(b, RotationalKc_un_m_per_rad(params_, bur_) * 1e-6 * dt_s, e);
}

void Core::ReadContact(const Pose& pose) noexcept {
  const double limit = kSampleVoxels * volume_.spec().voxel_m();
  if (sample_valid_ && cutting::Motion(pose, sampled_, reach_m_) < limit) return;
  ++work_.samples;
  engagement().Sample(volume_, pose);
  sampled_ = pose;
  sample_valid_ = true;
}

// The handpiece and the law have had the coupling's force by now.
void Core::AddCue(const TickInput& input, const dvec3& tip, bool unfelt, TickOutput& out) noexcept {
  haptics::TouchCueInput in;
  in.tip_m = tip;
  in.coupling_n = out.force_sent_n;
  in.pressed_n = out.pressed_n();
  in.across = orientation_.Matrix()[0];
  in.tissue_b_n_s_per_m = tissue_.b_n_s_per_m;
  in.bur_speed_krpm = bur_on_ ? input.bur_speed_krpm * handpiece_.speed_ratio() : 0;
  in.contact_read = tissue_.read;
  in.engaged = tissue_.engaged;
  in.suspended = (out.flags & kSuspended) != 0 || (out.flags & haptics::kLatched) != 0;
  in.bounded = (out.flags & haptics::kPeakBounded) != 0;
  in.gap = unfelt;
  out.cue_n = cues_.Tick(in);
  out.force_sent_n += out.cue_n;
}

void Core::Booked(bool complete) noexcept {
  if (!complete) reserve_exhausted_ = true;
  for (int32_t brick : cutter_.touched()) MarkTouched(brick);
  work_.bricks += static_cast<int>(cutter_.touched().size());
}

// All of the poses but the last one's upper half.
void Core::CutPoses(std::span<const Pose> due) noexcept {
  for (const Pose& pose : due) {
    CutRest();
    ++work_.cuts;
    Booked(cutter_.CutLower(pose, removed_));
    half_cut_ = pose;
    has_half_cut_ = true;
  }
}

void Core::CutRest() noexcept {
  if (!has_half_cut_) return;
  has_half_cut_ = false;
  Booked(cutter_.CutUpper(half_cut_, removed_));
}

// Cuts what the bur has passed and not yet cut, before it moves elsewhere or stops turning.
void Core::FinishCut() noexcept {
  CutPoses(sweep_.Flush());
  CutRest();
  sweep_.Clear();
}

TickOutput Core::Step(const TickInput& input) noexcept {
  TickOutput out;
  work_ = {};
  tissue_ = {};
  volume_.Warm();
  for (size_t i = 0; i < touched_count_; ++i) is_touched_[static_cast<size_t>(touched_[i])] = 0;
  touched_count_ = 0;
  cutting::RemovedUnits before = removed_;
  dvec3 tip = TipOf(input.counts);
  Quat device = FromQuantised(input.orientation);
  const size_t bur = BurIn(input.flags);
  const bool no_bur = bur >= engagements_.size(), changed = !no_bur && bur != bur_;
  if (changed) {
    FinishCut();
    UseBur(bur);
  }
  bool faulted = no_bur || (input.flags & kFaulted) != 0;
  bur_on_ = (input.flags & kBurOn) != 0 && !faulted;
  CutRest();
  if (!bur_on_) FinishCut();

  bool stop = !started_ || faulted || changed || (input.flags & kSoftRestart) != 0;
  bool unfelt = input.gap_ticks > 0 && (input.flags & kHeldGap) == 0;
  // While suspended a gap ends the count of free ticks: nobody saw that those were in air. A gap no
  // longer than the bus's delay ends before the forces under way do: nothing is known of the spring.
  bool lost =
      unfelt && !stop &&
      (suspended_ || input.gap_ticks <= params_.bus_delay_ticks || !ResumeAfterGap(tip, device));
  if (stop || lost) {
    Suspend(tip, device);
    started_ = true;
    out.flags |= kAnchorReset | kSuspended;
  } else if (suspended_) {
    AwaitFreeAir(tip, device);
    out.flags |= kSuspended;
  } else {
    // Also in the tick that bridges a gap: what the hand does from here on is paid only if it is felt.
    TissueMaterial material(*this);
    // The force of the tick before: this tick's depends on the speed that is set here.
    handpiece_.Step(bur_on_ ? resisting_n_ : 0, cutter_.bur().radius_m, bur_on_ ? drag_n_m_ : 0);
    drag_n_m_ = 0;
    dvec3 torque(0);
    if (torque_) {
      torque = FeelTurning(device, material);
    } else {
      FollowOrientation(device, material);
    }
    if (params_.spring_on_board) TakeSpring(input, out);
    haptics::CouplingOutput tick = coupling_.Tick(tip, 1, material);
    // A turn without a move; and a bur that stays lets what it has passed be cut in time.
    material.AnchorMoved(coupling_.anchor_m(), coupling_.anchor_m());
    out.flags |= tick.flags;
    if (step_too_long_) {
      step_too_long_ = false;
      Suspend(tip, device);
      out.flags |= kStepTooLong | kAnchorReset | kSuspended;
    } else {
      out.force_computed_n = tick.force_computed_n;
      out.force_sent_n = tick.force_sent_n;
      out.torque_sent_n_m = torque;
      if (params_.spring_on_board && (tick.flags & haptics::kLatched) == 0) {
        out.spring = {true, tick.follow, Quantise(tick.wish_m - TipOf({0, 0, 0}), 1e-9)};
      }
    }
  }
  resisting_n_ = std::sqrt(Dot(out.pressed_n(), out.pressed_n()));
  if (cues_.enabled()) AddCue(input, tip, unfelt, out);
  out.bur_speed_ratio = handpiece_.speed_ratio();
  out.anchor = {coupling_.anchor_m(), orientation_};
  if (reserve_exhausted_) out.flags |= kReserveExhausted;
  if (coupling_.stiffness_share() < 1) out.flags |= kSwingSeen;
  for (size_t t = 0; t < kTissueCount; ++t) out.removed[t] = removed_[t] - before[t];

  // Relative to it 32 bits of 100 nm reach 214 m, wherever the scene lies.
  dvec3 origin = TipOf({0, 0, 0});
  out.witness.force_sent_mn = Quantise(out.force_sent_n, 1e-3);
  out.witness.force_computed_mn = Quantise(out.force_computed_n, 1e-3);
  out.witness.anchor_100nm = Quantise(out.anchor.tip_m - origin, 1e-7);
  out.witness.flags = out.flags;
  wishes_[ticks_ % kWishes] = out.spring;
  ++ticks_;
  FoldHash(input, out);
  return out;
}

void Core::MarkTouched(int32_t brick) noexcept {
  auto b = static_cast<size_t>(brick);
  if (!is_touched_[b]) {
    is_touched_[b] = 1;
    touched_[touched_count_++] = brick;
  }
  if (!is_dirty_[b]) {
    is_dirty_[b] = 1;
    dirty_ring_[(dirty_head_ + dirty_count_) % dirty_ring_.size()] = brick;
    ++dirty_count_;
  }
}

void Core::FoldHash(const TickInput& input, const TickOutput& out) noexcept {
  hash_.I32x2(input.counts[0], input.counts[1]);
  hash_.I32x2(input.counts[2], static_cast<int32_t>(input.gap_ticks));
  // Only where there is one, like the torque below.
  if (params_.spring_on_board) {
    hash_.I32x2(input.rest_off_nm[0], input.rest_off_nm[1]);
    hash_.I32x2(input.rest_off_nm[2], input.share_lost);
  }
  for (int i = 0; i < 3; ++i) {
    hash_.F64(out.anchor.tip_m[i]);
    hash_.F64(out.force_sent_n[i]);
    // Only where there is one, or the hashes of all earlier recordings would be others.
    if (torque_) hash_.F64(out.torque_sent_n_m[i]);
  }
  hash_.F64(orientation_.x);
  hash_.F64(orientation_.y);
  hash_.F64(orientation_.z);
  hash_.F64(out.bur_speed_ratio);
  hash_.I32x2(input.flags, out.flags);
  for (int64_t r : out.removed) {
    if (r != 0) hash_.U64(static_cast<uint64_t>(r));
  }
  for (int n = 0; n < kHashedBricksPerTick && dirty_count_ > 0; ++n) {
    int32_t brick = dirty_ring_[dirty_head_];
    dirty_head_ = (dirty_head_ + 1) % dirty_ring_.size();
    --dirty_count_;
    is_dirty_[static_cast<size_t>(brick)] = 0;
    hash_.U64(static_cast<uint64_t>(brick));
    const auto& phi = volume_.Phi(brick).phi;
    std::array<uint64_t, cutting::kBrickVoxels / 4> words;
    if constexpr (std::endian::native == std::endian::little) {
      std::memcpy(words.data(), phi.data(), sizeof words);
    } else {
      // By value, not by memory layout, so that byte order cannot matter.
      for (size_t i = 0; i < phi.size(); ++i) {
        if (i % 4 == 0) words[i / 4] = 0;
        words[i / 4] |= uint64_t{static_cast<uint16_t>(phi[i])} << (16 * (i % 4));
      }
    }
    hash_.Words(words);
  }
}

}  // namespace enamel::core
