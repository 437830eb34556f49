#include "common/core/params.h"

#include <string>

namespace enamel::core {
namespace {

constexpr uint16_t kParamsFormat = 1;
// Bounds of what a file may ask for, not of a device: the strongest built-in one has a peak of 12 N
// (common/scene/builtin/profiles.cpp).
constexpr int32_t kMaxCue_mn = 2'000;
constexpr int32_t kMaxForce_mn = 100'000;
constexpr int32_t kMaxFeed_um_per_s = 1'000'000;
// Of the coarsest cell that a profile may have, with its noise (scene/cell.h): no coupling is left long before.
constexpr int32_t kMaxCell_nm = 30'000'000;

Status OutOfRange(const char* field, const std::string& expected, int64_t found) {
  return Status(Code::kInvalidInput,
                std::string("core parameter ") + field + ": expected " + expected + ", found " +
                    std::to_string(found),
                field);
}

Status CheckRange(const char* field, int64_t value, int64_t lo, int64_t hi) {
  if (value >= lo && value <= hi) return Status::Ok();
  return OutOfRange(field, std::to_string(lo) + " to " + std::to_string(hi), value);
}

// The first bur in the form of the others.
OtherBur FirstBur(const CoreParams& p) noexcept {
  return {p.bur_shape,
          p.bur_radius_nm,
          p.bur_length_nm,
          p.bur_narrow_radius_nm,
          p.shank_radius_nm,
          p.neck_nm,
          p.rotational_kc_un_m_per_rad};
}

OtherBur BurAt(const CoreParams& p, size_t bur) noexcept {
  return bur == 0 ? FirstBur(p) : p.other_burs[bur - 1];
}

cutting::Bur Metric(const OtherBur& p) noexcept {
  cutting::Bur bur;
  bur.shape = p.shape;
  bur.radius_m = p.radius_nm * 1e-9;
  bur.length_m = p.length_nm * 1e-9;
  bur.narrow_radius_m = p.narrow_radius_nm * 1e-9;
  bur.shank_radius_m = p.shank_radius_nm * 1e-9;
  bur.neck_m = p.neck_nm * 1e-9;
  return bur;
}

Status CheckBur(const OtherBur& p) {
  if (cutting::BurShapeName(p.shape) == "unknown") {
    return OutOfRange(
        "bur_shape",
        "1 to " + std::to_string(cutting::kBurShapeNames.size()) + " (schemas/trace_format.md)",
        static_cast<int>(p.shape));
  }
  const bool sphere = p.shape == cutting::BurShape::kSphere;
  ENAMEL_RETURN_IF_ERROR(CheckRange("bur_radius_nm", p.radius_nm, 50'000, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("bur_length_nm", p.length_nm, sphere ? 0 : 100'000, 20'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("bur_narrow_radius_nm", p.narrow_radius_nm, 0, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("shank_radius_nm", p.shank_radius_nm, 0, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("neck_nm", p.neck_nm, 0, 20'000'000));
  if (auto why = cutting::WhyImpossible(Metric(p))) {
    return Status(Code::kInvalidInput,
                  "core parameters: expected " + std::string(*why) + ", found radius " +
                      std::to_string(p.radius_nm) + " nm, narrow radius " +
                      std::to_string(p.narrow_radius_nm) + " nm, length " +
                      std::to_string(p.length_nm) + " nm",
                  "bur_narrow_radius_nm");
  }
  return CheckRange("rotational_kc_un_m_per_rad", p.rotational_kc_un_m_per_rad, 0, 100'000'000);
}

Status CheckBurs(const CoreParams& p) {
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("other_burs", static_cast<int64_t>(p.other_burs.size()), 0, kMaxBurs - 1));
  for (size_t i = 0; i < BurCount(p); ++i) {
    ENAMEL_RETURN_IF_ERROR(CheckBur(BurAt(p, i)));
    // What is felt is a spring of the device's, whatever bur it turns.
    if (p.peak_torque_un_m > 0 && RotationalKc_un_m_per_rad(p, i) != p.rotational_kc_un_m_per_rad) {
      return OutOfRange(
          "rotational_kc_un_m_per_rad",
          std::to_string(p.rotational_kc_un_m_per_rad) + " for each bur, as a torque is sent",
          RotationalKc_un_m_per_rad(p, i));
    }
  }
  return Status::Ok();
}

void WriteBur(const OtherBur& bur, ByteWriter& out) {
  out.U8(static_cast<uint8_t>(bur.shape));
  out.I32(bur.radius_nm);
  out.I32(bur.length_nm);
  out.I32(bur.narrow_radius_nm);
  out.I32(bur.shank_radius_nm);
  out.I32(bur.neck_nm);
  out.I32(bur.rotational_kc_un_m_per_rad);
}

OtherBur ReadBur(ByteReader& in) {
  OtherBur bur;
  bur.shape = static_cast<cutting::BurShape>(in.U8());
  bur.radius_nm = in.I32();
  bur.length_nm = in.I32();
  bur.narrow_radius_nm = in.I32();
  bur.shank_radius_nm = in.I32();
  bur.neck_nm = in.I32();
  bur.rotational_kc_un_m_per_rad = in.I32();
  return bur;
}

Status CheckTorqueAndCues(const CoreParams& p) {
  ENAMEL_RETURN_IF_ERROR(CheckRange("peak_torque_un_m", p.peak_torque_un_m, 0, 100'000'000));
  const bool torque = p.peak_torque_un_m > 0;
  ENAMEL_RETURN_IF_ERROR(CheckRange("rotation_cell_urad", p.rotation_cell_urad,
                                    torque ? kMinRotationCell_urad : 0, 100'000));
  if (torque) {
    ENAMEL_RETURN_IF_ERROR(
        CheckRange("rotational_kc_un_m_per_rad", p.rotational_kc_un_m_per_rad, 1, 100'000'000));
    // Twice what the guard holds back, or the bur could not follow the hand through air.
    const int64_t least =
        (int64_t{2} * p.rotational_kc_un_m_per_rad * p.rotation_cell_urad + 999'999) / 1'000'000;
    ENAMEL_RETURN_IF_ERROR(CheckRange("peak_torque_un_m", p.peak_torque_un_m, least, 100'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("contact_cue_mn", p.contact_cue_mn, 0, kMaxCue_mn));
  ENAMEL_RETURN_IF_ERROR(CheckRange("chatter_cue_mn", p.chatter_cue_mn, 0, kMaxCue_mn));
  ENAMEL_RETURN_IF_ERROR(CheckRange("cue_energy_nj", p.cue_energy_nj, 0, 1'000'000));
  return CheckRange("cue_power_nw", p.cue_power_nw, 0, 10'000'000);
}

Status CheckLoad(const CoreParams& p) {
  bool drags = false;
  for (size_t t = 0; t < cutting::kTissueCount; ++t) {
    const auto exponent = static_cast<int>(p.feed_exponent[t]);
    ENAMEL_RETURN_IF_ERROR(CheckRange("feed_exponent", exponent, 0, 2));
    const bool linear = p.feed_exponent[t] == cutting::FeedExponent::kOne;
    ENAMEL_RETURN_IF_ERROR(
        CheckRange("feed_um_per_s", p.feed_um_per_s[t], linear ? 0 : 1, kMaxFeed_um_per_s));
    ENAMEL_RETURN_IF_ERROR(
        CheckRange("bur_friction_permille", p.bur_friction_permille[t], 0, 2'000));
    drags = drags || p.bur_friction_permille[t] > 0;
  }
  // The torque on the spindle would be counted twice.
  if (drags && p.handpiece_tangential_permille != 0) {
    return OutOfRange("handpiece_tangential_permille", "0, as a tissue has a friction of its own",
                      p.handpiece_tangential_permille);
  }
  return Status::Ok();
}

Status CheckValues(const CoreParams& p) {
  ENAMEL_RETURN_IF_ERROR(CheckRange("rate_hz", p.rate_hz, 100, 20000));
  if (haptics::FindLaw(p.law) == nullptr) {
    return OutOfRange("law", "a known force law", static_cast<int>(p.law));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("kc_mn_per_mm", p.kc_mn_per_mm, 1, 1'000'000));
  if (p.spring_on_board && p.law != haptics::LawKind::kMaxwell &&
      p.law != haptics::LawKind::kLeadMaxwell) {
    // The others either have no rest point to send, or a damper beside the spring.
    return OutOfRange("law", "maxwell or lead-maxwell, with the spring on the device's board",
                      static_cast<int>(p.law));
  }
  for (int32_t r : p.resolution_nm)
    ENAMEL_RETURN_IF_ERROR(CheckRange("resolution_nm", r, 1, 1'000'000));
  for (int32_t h : p.cell_half_nm)
    ENAMEL_RETURN_IF_ERROR(CheckRange("cell_half_nm", h, 0, kMaxCell_nm));
  ENAMEL_RETURN_IF_ERROR(CheckRange("cell_ball_nm", p.cell_ball_nm, 0, kMaxCell_nm));
  for (int32_t c : p.friction_mn)
    ENAMEL_RETURN_IF_ERROR(CheckRange("friction_mn", c, 0, kMaxForce_mn));
  for (int64_t o : p.device_origin_nm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("device_origin_nm", o, -1'000'000'000, 1'000'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("peak_force_mn", p.peak_force_mn, 1, kMaxForce_mn));
  ENAMEL_RETURN_IF_ERROR(CheckRange("soft_start_ticks", p.soft_start_ticks, 0, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckBurs(p));
  for (int32_t b : p.damping_mn_s_per_mm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("damping_mn_s_per_mm", b, 0, 1'000'000'000));
  }
  for (int32_t b : p.axial_damping_mn_s_per_mm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("axial_damping_mn_s_per_mm", b, 0, 1'000'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("handpiece_stall_un_m", p.handpiece_stall_un_m, 0, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("handpiece_tangential_permille", p.handpiece_tangential_permille, 0, 10'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("handpiece_lag_us", p.handpiece_lag_us, 0, 10'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("bus_delay_ticks", p.bus_delay_ticks, 0, 16));
  for (int32_t f : p.coulomb_mn) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("coulomb_mn", f, 0, kMaxForce_mn));
  }
  ENAMEL_RETURN_IF_ERROR(CheckLoad(p));
  return CheckTorqueAndCues(p);
}

}  // namespace

cutting::Bur BurOf(const CoreParams& p, size_t bur) noexcept { return Metric(BurAt(p, bur)); }

std::vector<cutting::Bur> BursOf(const CoreParams& p) {
  std::vector<cutting::Bur> out;
  for (size_t i = 0; i < BurCount(p); ++i) out.push_back(BurOf(p, i));
  return out;
}

int32_t RotationalKc_un_m_per_rad(const CoreParams& p, size_t bur) noexcept {
  return BurAt(p, bur).rotational_kc_un_m_per_rad;
}

haptics::OwnFriction OwnFrictionOf(const CoreParams& p) noexcept {
  return {dvec3(p.friction_mn[0], p.friction_mn[1], p.friction_mn[2]) * 1e-3, p.friction_measured};
}

haptics::TipCell TipCellOf(const CoreParams& p) noexcept {
  const dvec3 half(p.cell_half_nm[0], p.cell_half_nm[1], p.cell_half_nm[2]);
  if (half == dvec3(0) && p.cell_ball_nm == 0) {
    return haptics::CartesianCell(
        dvec3(p.resolution_nm[0], p.resolution_nm[1], p.resolution_nm[2]) * 1e-9);
  }
  haptics::TipCell cell;
  cell.half_m = half * 1e-9;
  cell.ball_m = p.cell_ball_nm * 1e-9;
  return cell;
}

Status ValidateParams(const CoreParams& p) {
  if (p.core_version != kCoreVersion) {
    return Status(Code::kVersion,
                  "this program runs core version " + std::to_string(kCoreVersion) +
                      ", the attempt was made with version " + std::to_string(p.core_version) +
                      ": it can be listed, and replayed by a program of that version",
                  "core_version");
  }
  return CheckValues(p);
}

void WriteParams(const CoreParams& p, ByteWriter& out) {
  out.U16(kParamsFormat);
  out.U32(p.core_version);
  out.U32(p.rate_hz);
  out.U8(static_cast<uint8_t>(p.law));
  out.U8(p.pass_through_at_rest ? 1 : 0);
  out.I32(p.kc_mn_per_mm);
  for (int32_t r : p.resolution_nm) out.I32(r);
  for (int64_t o : p.device_origin_nm) out.I64(o);
  out.I32(p.peak_force_mn);
  out.U32(p.soft_start_ticks);
  out.U8(static_cast<uint8_t>(p.bur_shape));
  out.I32(p.bur_radius_nm);
  out.I32(p.bur_length_nm);
  out.U8(cutting::kTissueCount);
  for (int32_t b : p.damping_mn_s_per_mm) out.I32(b);
  out.I32(p.rotational_kc_un_m_per_rad);
  out.I32(p.bur_narrow_radius_nm);
  out.I32(p.shank_radius_nm);
  out.I32(p.neck_nm);
  for (int32_t b : p.axial_damping_mn_s_per_mm) out.I32(b);
  out.I32(p.handpiece_stall_un_m);
  out.I32(p.handpiece_tangential_permille);
  out.I32(p.handpiece_lag_us);
  out.U32(p.bus_delay_ticks);
  out.I32(p.peak_torque_un_m);
  for (int32_t f : p.coulomb_mn) out.I32(f);
  for (int32_t f : p.feed_um_per_s) out.I32(f);
  for (int32_t f : p.bur_friction_permille) out.I32(f);
  for (cutting::FeedExponent m : p.feed_exponent) out.U8(static_cast<uint8_t>(m));
  out.I32(p.rotation_cell_urad);
  out.I32(p.contact_cue_mn);
  out.I32(p.chatter_cue_mn);
  out.I32(p.cue_energy_nj);
  out.I32(p.cue_power_nw);
  for (int32_t h : p.cell_half_nm) out.I32(h);
  out.I32(p.cell_ball_nm);
  out.U8(p.spring_on_board ? 1 : 0);
  for (int32_t c : p.friction_mn) out.I32(c);
  out.U8(p.friction_measured ? 1 : 0);
  out.U8(static_cast<uint8_t>(p.other_burs.size()));
  for (const OtherBur& bur : p.other_burs) WriteBur(bur, out);
}

Result<CoreParams> ReadParams(ByteReader& in) {
  CoreParams p;
  const uint16_t format = in.U16();
  if (in.ok() && format != kParamsFormat) {
    return Status(Code::kVersion, "core parameters are of format " + std::to_string(format) +
                                      ", this program reads format " +
                                      std::to_string(kParamsFormat));
  }
  p.core_version = in.U32();
  p.rate_hz = in.U32();
  p.law = static_cast<haptics::LawKind>(in.U8());
  p.pass_through_at_rest = in.U8() != 0;
  p.kc_mn_per_mm = in.I32();
  for (int32_t& r : p.resolution_nm) r = in.I32();
  for (int64_t& o : p.device_origin_nm) o = in.I64();
  p.peak_force_mn = in.I32();
  p.soft_start_ticks = in.U32();
  p.bur_shape = static_cast<cutting::BurShape>(in.U8());
  p.bur_radius_nm = in.I32();
  p.bur_length_nm = in.I32();
  // Said in the bytes, so that a recording with one tissue more is refused and not read askew.
  uint8_t tissues = in.U8();
  if (in.ok() && tissues != cutting::kTissueCount) {
    return Status(Code::kVersion, "core parameters name " + std::to_string(tissues) +
                                      " tissues, this core knows " +
                                      std::to_string(cutting::kTissueCount));
  }
  for (int32_t& b : p.damping_mn_s_per_mm) b = in.I32();
  p.rotational_kc_un_m_per_rad = in.I32();
  p.bur_narrow_radius_nm = in.I32();
  p.shank_radius_nm = in.I32();
  p.neck_nm = in.I32();
  for (int32_t& b : p.axial_damping_mn_s_per_mm) b = in.I32();
  p.handpiece_stall_un_m = in.I32();
  p.handpiece_tangential_permille = in.I32();
  p.handpiece_lag_us = in.I32();
  p.bus_delay_ticks = in.U32();
  p.peak_torque_un_m = in.I32();
  for (int32_t& f : p.coulomb_mn) f = in.I32();
  for (int32_t& f : p.feed_um_per_s) f = in.I32();
  for (int32_t& f : p.bur_friction_permille) f = in.I32();
  for (cutting::FeedExponent& m : p.feed_exponent) m = static_cast<cutting::FeedExponent>(in.U8());
  p.rotation_cell_urad = in.I32();
  p.contact_cue_mn = in.I32();
  p.chatter_cue_mn = in.I32();
  p.cue_energy_nj = in.I32();
  p.cue_power_nw = in.I32();
  for (int32_t& h : p.cell_half_nm) h = in.I32();
  p.cell_ball_nm = in.I32();
  p.spring_on_board = in.U8() != 0;
  for (int32_t& c : p.friction_mn) c = in.I32();
  p.friction_measured = in.U8() != 0;
  const uint8_t other_burs = in.U8();
  if (in.ok() && other_burs >= kMaxBurs) {
    return OutOfRange("other_burs", "0 to " + std::to_string(kMaxBurs - 1), other_burs);
  }
  for (int i = 0; i < other_burs; ++i) p.other_burs.push_back(ReadBur(in));
  if (!in.ok()) return Status(Code::kInvalidInput, "core parameters end early");
  // Values, but not the version: a recording that cannot be run can still be listed.
  ENAMEL_RETURN_IF_ERROR(CheckValues(p));
  return p;
}

}  // namespace enamel::core
