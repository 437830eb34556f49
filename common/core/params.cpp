#include "common/core/params.h"

#include <string>

namespace enamel::core {
namespace {

constexpr uint16_t kParamsVersion = 1;

Status OutOfRange(const char* field, const std::string& expected, int64_t found) {
  return Status(Code::kInvalidInput,
                std::string("core parameter ") + field + ": expected " + expected + ", found " +
                    std::to_string(found), field);
}

Status CheckRange(const char* field, int64_t value, int64_t lo, int64_t hi) {
  if (value >= lo && value <= hi) return Status::Ok();
  return OutOfRange(field, std::to_string(lo) + " to " + std::to_string(hi), value);
}

}  // namespace

Status ValidateParams(const CoreParams& p) {
  if (p.core_version != kCoreVersion) {
    return Status(Code::kVersion, "this program runs core version " + std::to_string(kCoreVersion) +
                                      ", the attempt was made with version " +
                                      std::to_string(p.core_version), "core_version");
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("rate_hz", p.rate_hz, 100, 20000));
  if (haptics::FindLaw(p.law) == nullptr) {
    return OutOfRange("law", "a known force law", static_cast<int>(p.law));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("kc_mn_per_mm", p.kc_mn_per_mm, 1, 1'000'000));
  for (int32_t r : p.resolution_nm) ENAMEL_RETURN_IF_ERROR(CheckRange("resolution_nm", r, 1, 1'000'000));
  for (int64_t o : p.device_origin_nm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("device_origin_nm", o, -1'000'000'000, 1'000'000'000));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("peak_force_mn", p.peak_force_mn, 1, 100'000));
  ENAMEL_RETURN_IF_ERROR(CheckRange("soft_start_ticks", p.soft_start_ticks, 0, 1'000'000));
  if (p.bur_shape != cutting::BurShape::kSphere && p.bur_shape != cutting::BurShape::kCylinder) {
    return OutOfRange("bur_shape", "1 (sphere) or 2 (cylinder)", static_cast<int>(p.bur_shape));
  }
  ENAMEL_RETURN_IF_ERROR(CheckRange("bur_radius_nm", p.bur_radius_nm, 50'000, 5'000'000));
  if (p.bur_shape == cutting::BurShape::kCylinder) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("bur_length_nm", p.bur_length_nm, 100'000, 20'000'000));
  }
  for (int32_t b : p.damping_mn_s_per_mm) {
    ENAMEL_RETURN_IF_ERROR(CheckRange("damping_mn_s_per_mm", b, 0, 1'000'000'000));
  }
  return CheckRange("rotational_kc_un_m_per_rad", p.rotational_kc_un_m_per_rad, 0, 100'000'000);
}

void WriteParams(const CoreParams& p, ByteWriter& out) {
  out.U16(kParamsVersion);
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
}

Result<CoreParams> ReadParams(ByteReader& in) {
  CoreParams p;
  uint16_t version = in.U16();
  if (in.ok() && version != kParamsVersion) {
    return Status(Code::kVersion, "core parameters are of format " + std::to_string(version) +
                                      ", this program reads format " + std::to_string(kParamsVersion));
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
  uint8_t tissues = in.U8();
  if (in.ok() && tissues != cutting::kTissueCount) {
    return Status(Code::kVersion, "core parameters name " + std::to_string(tissues) +
                                      " tissues, this core knows " +
                                      std::to_string(cutting::kTissueCount));
  }
  for (int32_t& b : p.damping_mn_s_per_mm) b = in.I32();
  p.rotational_kc_un_m_per_rad = in.I32();
  if (!in.ok()) return Status(Code::kInvalidInput, "core parameters end early");
  ENAMEL_RETURN_IF_ERROR(ValidateParams(p));
  return p;
}

}  // namespace enamel::core
