#include "common/core/params.h"

#include <string>

namespace enamel::core {
namespace {

constexpr uint16_t kParamsVersion = 4;
// Bounds of what a file may ask for, not of a device: the strongest built-in one has a peak of 12 N
// (common/scene/builtin/profiles.cpp).
constexpr int32_t kMaxCue_mn = 2'000;
constexpr int32_t kMaxForce_mn = 100'000;

// A format per core version; 0 is read like 2, and what is newer than this program like the newest.
uint16_t FormatOf(uint32_t core_version) noexcept {
  if (core_version == 0) return 2;
  return core_version < kParamsVersion ? static_cast<uint16_t>(core_version) : kParamsVersion;
}

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

Status CheckBur(const CoreParams& p) {
  if (cutting::BurShapeName(p.bur_shape) == "unknown") {
    return OutOfRange(
        "bur_shape",
        "1 to " + std::to_string(cutting::kBurShapeNames.size()) + " (schemas/trace_format.md)",
        static_cast<int>(p.bur_shape));
  }
  const bool sphere = p.bur_shape == cutting::BurShape::kSphere;
  ENAMEL_RETURN_IF_ERROR(CheckRange("bur_radius_nm", p.bur_radius_nm, 50'000, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("bur_length_nm", p.bur_length_nm, sphere ? 0 : 100'000, 20'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("bur_narrow_radius_nm", p.bur_narrow_radius_nm, 0, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("shank_radius_nm", p.shank_radius_nm, 0, 5'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("neck_nm", p.neck_nm, 0, 20'000'000));
  if (auto why = cutting::WhyImpossible(BurOf(p))) {
    return Status(Code::kInvalidInput,
                  "core parameters: expected " + std::string(*why) + ", found radius " +
                      std::to_string(p.bur_radius_nm) + " nm, narrow radius " +
                      std::to_string(p.bur_narrow_radius_nm) + " nm, length " +
                      std::to_string(p.bur_length_nm) + " nm",
                  "bur_narrow_radius_nm");
  }
  return Status::Ok();
}

Status CheckVersion3(const CoreParams& p) {
  // What a version did not have must be at its default in it: its bytes have no field to hold
  // anything else (WriteParams), and a replay would run with other values than the attempt.
  const bool known = p.core_version >= 3;
  auto check = [&](const char* field, int64_t value, int64_t most) {
    return CheckRange(field, value, 0, known ? most : 0);
  };
  ENAMEL_RETURN_IF_ERROR(check("bus_delay_ticks", p.bus_delay_ticks, 16));
  for (int32_t f : p.coulomb_mn) ENAMEL_RETURN_IF_ERROR(check("coulomb_mn", f, kMaxForce_mn));
  for (int32_t f : p.threshold_mn) ENAMEL_RETURN_IF_ERROR(check("threshold_mn", f, kMaxForce_mn));
  return Status::Ok();
}

Status CheckVersion4(const CoreParams& p) {
  const bool known = p.core_version >= 4;
  auto check = [&](const char* field, int64_t value, int64_t most) {
    return CheckRange(field, value, 0, known ? most : 0);
  };
  // Version 3 had the field, and sent no torque.
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("peak_torque_un_m", p.peak_torque_un_m, 0, p.core_version >= 3 ? 100'000'000 : 0));
  const bool torque = known && p.peak_torque_un_m > 0;
  ENAMEL_RETURN_IF_ERROR(CheckRange("rotation_cell_urad", p.rotation_cell_urad,
                                    torque ? kLeastRotationCell_urad : 0, known ? 100'000 : 0));
  if (torque) {
    ENAMEL_RETURN_IF_ERROR(
        CheckRange("rotational_kc_un_m_per_rad", p.rotational_kc_un_m_per_rad, 1, 100'000'000));
    // Twice what the guard holds back, or the bur could not follow the hand through air.
    const int64_t least =
        (int64_t{2} * p.rotational_kc_un_m_per_rad * p.rotation_cell_urad + 999'999) / 1'000'000;
    ENAMEL_RETURN_IF_ERROR(CheckRange("peak_torque_un_m", p.peak_torque_un_m, least, 100'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(check("contact_cue_mn", p.contact_cue_mn, kMaxCue_mn));
  ENAMEL_RETURN_IF_ERROR(check("chatter_cue_mn", p.chatter_cue_mn, kMaxCue_mn));
  ENAMEL_RETURN_IF_ERROR(check("cue_energy_nj", p.cue_energy_nj, 1'000'000));
  return check("cue_power_nw", p.cue_power_nw, 10'000'000);
}

Status CheckValues(const CoreParams& p) {
  ENAMEL_RETURN_IF_ERROR(CheckRange("rate_hz", p.rate_hz, 100, 20000));
  if (haptics::FindLaw(p.law) == nullptr) {
    return OutOfRange("law", "a known force law", static_cast<int>(p.law));
  }
  if (p.law == haptics::LawKind::kTankMaxwell && p.core_version < 3) {
    return OutOfRange("law", "a law that core version 2 had", static_cast<int>(p.law));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("kc_mn_per_mm", p.kc_mn_per_mm, 1, 1'000'000));
  for (int32_t r : p.resolution_nm)
    ENAMEL_RETURN_IF_ERROR(CheckRange("resolution_nm", r, 1, 1'000'000));
  for (int64_t o : p.device_origin_nm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("device_origin_nm", o, -1'000'000'000, 1'000'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("peak_force_mn", p.peak_force_mn, 1, kMaxForce_mn));
  ENAMEL_RETURN_IF_ERROR(CheckRange("soft_start_ticks", p.soft_start_ticks, 0, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckBur(p));
  for (int32_t b : p.damping_mn_s_per_mm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("damping_mn_s_per_mm", b, 0, 1'000'000'000));
  }
  for (int32_t b : p.axial_damping_mn_s_per_mm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("axial_damping_mn_s_per_mm", b, 0, 1'000'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("rotational_kc_un_m_per_rad", p.rotational_kc_un_m_per_rad, 0, 100'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("handpiece_stall_un_m", p.handpiece_stall_un_m, 0, 1'000'000));
  ENAMEL_RETURN_IF_ERROR(
      CheckRange("handpiece_tangential_permille", p.handpiece_tangential_permille, 0, 10'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("handpiece_lag_us", p.handpiece_lag_us, 0, 10'000'000));
  ENAMEL_RETURN_IF_ERROR(CheckVersion3(p));
  return CheckVersion4(p);
}

}  // namespace

cutting::Bur BurOf(const CoreParams& p) noexcept {
  cutting::Bur bur;
  bur.shape = p.bur_shape;
  bur.radius_m = p.bur_radius_nm * 1e-9;
  bur.length_m = p.bur_length_nm * 1e-9;
  bur.narrow_radius_m = p.bur_narrow_radius_nm * 1e-9;
  bur.shank_radius_m = p.shank_radius_nm * 1e-9;
  bur.neck_m = p.neck_nm * 1e-9;
  return bur;
}

Status ValidateParams(const CoreParams& p) {
  if (p.core_version < kOldestCoreVersion || p.core_version > kCoreVersion) {
    return Status(Code::kVersion,
                  "this program runs core versions " + std::to_string(kOldestCoreVersion) + " to " +
                      std::to_string(kCoreVersion) + ", the attempt was made with version " +
                      std::to_string(p.core_version) +
                      ": it can be listed, and re-run by a program of that version",
                  "core_version");
  }
  return CheckValues(p);
}

CoreParams AsOfVersion(CoreParams p, uint32_t version) noexcept {
  const CoreParams defaults;
  p.core_version = version;
  if (version < 4) {
    p.peak_torque_un_m = defaults.peak_torque_un_m;
    p.rotation_cell_urad = defaults.rotation_cell_urad;
    p.contact_cue_mn = defaults.contact_cue_mn;
    p.chatter_cue_mn = defaults.chatter_cue_mn;
    p.cue_energy_nj = defaults.cue_energy_nj;
    p.cue_power_nw = defaults.cue_power_nw;
  }
  if (version < 3) {
    p.bus_delay_ticks = defaults.bus_delay_ticks;
    p.coulomb_mn = defaults.coulomb_mn;
    p.threshold_mn = defaults.threshold_mn;
  }
  if (version < 2) {
    p.bur_narrow_radius_nm = defaults.bur_narrow_radius_nm;
    p.shank_radius_nm = defaults.shank_radius_nm;
    p.neck_nm = defaults.neck_nm;
    p.axial_damping_mn_s_per_mm = defaults.axial_damping_mn_s_per_mm;
    p.handpiece_stall_un_m = defaults.handpiece_stall_un_m;
    p.handpiece_tangential_permille = defaults.handpiece_tangential_permille;
    p.handpiece_lag_us = defaults.handpiece_lag_us;
  }
  return p;
}

size_t ParamsBytes(uint32_t core_version) noexcept {
  // What WriteParams writes, counted by CoreParamsTest for every version.
  constexpr size_t kBytes[kParamsVersion] = {106, 162, 234, 254};
  return kBytes[FormatOf(core_version) - 1];
}

void WriteParams(const CoreParams& p, ByteWriter& out) {
  // Fields are only ever added at the end, so an earlier format is where writing stops.
  const uint16_t format = FormatOf(p.core_version);
  out.U16(format);
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
  if (format < 2) return;
  out.I32(p.bur_narrow_radius_nm);
  out.I32(p.shank_radius_nm);
  out.I32(p.neck_nm);
  for (int32_t b : p.axial_damping_mn_s_per_mm) out.I32(b);
  out.I32(p.handpiece_stall_un_m);
  out.I32(p.handpiece_tangential_permille);
  out.I32(p.handpiece_lag_us);
  if (format < 3) return;
  out.U32(p.bus_delay_ticks);
  out.I32(p.peak_torque_un_m);
  for (int32_t f : p.coulomb_mn) out.I32(f);
  for (int32_t f : p.threshold_mn) out.I32(f);
  if (format < 4) return;
  out.I32(p.rotation_cell_urad);
  out.I32(p.contact_cue_mn);
  out.I32(p.chatter_cue_mn);
  out.I32(p.cue_energy_nj);
  out.I32(p.cue_power_nw);
}

Result<CoreParams> ReadParams(ByteReader& in) {
  CoreParams p;
  uint16_t version = in.U16();
  if (in.ok() && (version < 1 || version > kParamsVersion)) {
    return Status(Code::kVersion, "core parameters are of format " + std::to_string(version) +
                                      ", this program reads formats 1 to " +
                                      std::to_string(kParamsVersion));
  }
  // Both are written, and must agree: the format alone says how to read on.
  p.core_version = in.U32();
  if (in.ok() && version != FormatOf(p.core_version)) {
    return Status(Code::kInvalidInput, "core parameters: expected format " +
                                           std::to_string(FormatOf(p.core_version)) +
                                           " for core version " + std::to_string(p.core_version) +
                                           ", found format " + std::to_string(version));
  }
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
  if (version >= 2) {
    p.bur_narrow_radius_nm = in.I32();
    p.shank_radius_nm = in.I32();
    p.neck_nm = in.I32();
    for (int32_t& b : p.axial_damping_mn_s_per_mm) b = in.I32();
    p.handpiece_stall_un_m = in.I32();
    p.handpiece_tangential_permille = in.I32();
    p.handpiece_lag_us = in.I32();
  }
  if (version >= 3) {
    p.bus_delay_ticks = in.U32();
    p.peak_torque_un_m = in.I32();
    for (int32_t& f : p.coulomb_mn) f = in.I32();
    for (int32_t& f : p.threshold_mn) f = in.I32();
  }
  if (version >= 4) {
    p.rotation_cell_urad = in.I32();
    p.contact_cue_mn = in.I32();
    p.chatter_cue_mn = in.I32();
    p.cue_energy_nj = in.I32();
    p.cue_power_nw = in.I32();
  }
  if (!in.ok()) return Status(Code::kInvalidInput, "core parameters end early");
  // Values, but not the version: a recording that cannot be run can still be listed.
  ENAMEL_RETURN_IF_ERROR(CheckValues(p));
  return p;
}

}  // namespace enamel::core
