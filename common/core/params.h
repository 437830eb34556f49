#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/bur.h"
#include "common/cutting/tissue.h"
#include "common/haptics/coupling.h"
#include "common/haptics/force_law.h"
#include "common/haptics/guard.h"

namespace enamel::core {

// A recording replays to the bit in the core version that made it, and in no other. A server lets
// only stations of its own core version begin an attempt.
inline constexpr uint32_t kCoreVersion = 1;

// The error of rounding an orientation to four 16-bit numbers alone: |dq| <= 1/32767, and an angle
// is twice that.
inline constexpr int32_t kMinRotationCell_urad = 62;

// A bur that the handpiece can be given in place of the first one (CoreParams::other_burs).
struct OtherBur {
  cutting::BurShape shape = cutting::BurShape::kSphere;
  int32_t radius_nm = 0, length_nm = 0, narrow_radius_nm = 0;  // cutting::Bur
  int32_t shank_radius_nm = 0, neck_nm = 0;
  // As CoreParams::rotational_kc_un_m_per_rad, which depends on the bur's height.
  int32_t rotational_kc_un_m_per_rad = 0;

  bool operator==(const OtherBur&) const = default;
};

// Everything the core's result depends on besides the initial volume and the recorded inputs.
// Integers with units, never decimal text, so that both sides start from the same bits. Written
// into every attempt header (schemas/trace_format.md, "Core parameters").
struct CoreParams {
  uint32_t core_version = kCoreVersion;
  uint32_t rate_hz = 1000;
  haptics::LawKind law = haptics::LawKind::kMaxwell;
  bool pass_through_at_rest = false;       // eq. 17's rule for dp = 0 (force_law.h)
  int32_t kc_mn_per_mm = 0;                // coupling stiffness, 1 mN/mm = 1 N/m
  std::array<int32_t, 3> resolution_nm{};  // edge of a recorded count per axis
  // Tip in the scene = device_origin + counts * resolution (counts are cell middles).
  std::array<int64_t, 3> device_origin_nm{};
  int32_t peak_force_mn = 0;
  // Ticks the bur must be in free air, without a break, before force and cutting are switched on:
  // at the start, after a fault, after a gap that moved the hand too far.
  uint32_t soft_start_ticks = 500;
  cutting::BurShape bur_shape = cutting::BurShape::kSphere;
  int32_t bur_radius_nm = 0;
  int32_t bur_length_nm = 0;
  int32_t bur_narrow_radius_nm = 0;  // cutting::Bur
  int32_t shank_radius_nm = 0;       // 0: no shank
  int32_t neck_nm = 0;
  std::array<int32_t, cutting::kTissueCount>
      damping_mn_s_per_mm{};  // B per tissue, across the bur's axis
  // B along the axis; 0: as across it.
  std::array<int32_t, cutting::kTissueCount> axial_damping_mn_s_per_mm{};
  // Rotational coupling: stiffness about each axis, uN m per rad. 0: orientation is not followed at
  // all, the bur keeps the one it was switched on with.
  int32_t rotational_kc_un_m_per_rad = 0;
  // Handpiece (handpiece.h). Torque that stalls the bur; 0: its speed does not fall.
  int32_t handpiece_stall_un_m = 0;
  int32_t handpiece_tangential_permille =
      0;  // tangential force at the bur's radius per resisting force
  int32_t handpiece_lag_us = 0;
  uint32_t bus_delay_ticks = 0;  // between reading a position and the force that answers it
  int32_t peak_torque_un_m = 0;  // bound on the torque's magnitude; 0: no torque is sent
  // Tissue that is cut by load (cutting::TissueDamping), for the engagement that damping_mn_s_per_mm is of. The force
  // below which the bur does not cut. The feed v0 at which B is meant, needed where m is not 1. The tangential force on
  // the bur's surface per normal force.
  std::array<int32_t, cutting::kTissueCount> coulomb_mn{}, feed_um_per_s{}, bur_friction_permille{};
  // m, with which the force grows with the feed.
  cutting::FeedExponents feed_exponent = cutting::AllLinear();
  // Largest angle between the true and the measured orientation, urad: what the torque's guard
  // counts with, kMinRotationCell_urad of which are the recording's own. Needed where a torque is
  // sent; then rotational_kc_un_m_per_rad is needed too, and peak_torque_un_m >= 2 K cell.
  int32_t rotation_cell_urad = 0;
  // Touch cues: the largest force of the knock on contact and of the bur's chatter, and the energy
  // they may give the hand: at once, and refilled with time. 0: none.
  int32_t contact_cue_mn = 0, chatter_cue_mn = 0, cue_energy_nj = 0, cue_power_nw = 0;
  // Where the true tip can be around a recorded position (haptics::TipCell): half edges of a box and radius of
  // a ball, added up. All 0: half a count on each axis, a device that records what it counts.
  std::array<int32_t, 3> cell_half_nm{};
  int32_t cell_ball_nm = 0;
  // The device's board runs the coupling's spring (common/board/board.h): the core says where its rest
  // point should be, and TickInput says where it is. bus_delay_ticks is then that of the reports: a wish
  // sent in answer to a reading holds in the reading 1 + bus_delay_ticks later.
  bool spring_on_board = false;
  // The device's Coulomb friction per axis, which the law takes out of the force in the hand, and whether it is this
  // unit's own. A measured one must not be more than the unit has: the motors push with it (haptics::OwnFriction).
  std::array<int32_t, 3> friction_mn{};
  bool friction_measured = false;
  // Burs 1, 2, ... of the attempt; bur 0 is the one above. Each cuts with the same B.
  std::vector<OtherBur> other_burs;

  bool operator==(const CoreParams&) const = default;
};

// As many as the three bits that name a bur in a tick can tell apart.
inline constexpr size_t kMaxBurs = 8;
inline size_t BurCount(const CoreParams& params) noexcept { return 1 + params.other_burs.size(); }
// Requires, here and below: bur < BurCount(params).
cutting::Bur BurOf(const CoreParams& params, size_t bur = 0) noexcept;
// All of them, in order.
std::vector<cutting::Bur> BursOf(const CoreParams& params);
int32_t RotationalKc_un_m_per_rad(const CoreParams& params, size_t bur) noexcept;
haptics::TipCell TipCellOf(const CoreParams& params) noexcept;
// The device's own friction, for the law.
haptics::OwnFriction OwnFrictionOf(const CoreParams& params) noexcept;

// Refuses what the core cannot run with, naming the field: kVersion for a recording of a core that
// this program does not run, kInvalidInput for a value out of range. Also the passivity premise on
// kc is the profile's business (haptics), not checked here.
Status ValidateParams(const CoreParams& params);

// Canonical little-endian form, versioned (first u16); see schemas/trace_format.md.
inline constexpr size_t kOtherBurBytes = 25;
inline constexpr size_t kMinParamsBytes = 325;  // with one bur
inline constexpr size_t kMaxParamsBytes = kMinParamsBytes + (kMaxBurs - 1) * kOtherBurBytes;
void WriteParams(const CoreParams& params, ByteWriter& out);
// Reads any core version, so that another version's recording can be listed; whoever runs a core
// calls ValidateParams. Errors: kInvalidInput (cut short, or a value out of range), kVersion
// (format).
Result<CoreParams> ReadParams(ByteReader& in);

}  // namespace enamel::core
