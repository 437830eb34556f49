#include "common/scene/rate.h"

#include <string>

#include "common/scene/delay.h"

namespace enamel::scene {

const char* CouplingLimitName(CouplingLimit limit) {
  constexpr const char* kNames[] = {"damping", "friction", "structure"};
  return kNames[static_cast<int>(limit)];
}

LargestCoupling LargestCouplingAt(const DeviceProfile& profile, int64_t rate_hz,
                                  int64_t delay_ticks) {
  LargestCoupling out{PassiveCoupling_mn_per_mm(profile, rate_hz, delay_ticks),
                      CouplingLimit::kDamping};
  auto bounded = [&](int64_t most, CouplingLimit limit) {
    if (most < out.coupling_mn_per_mm) out = {most, limit};
  };
  // Does not depend on the rate, and is why a faster loop does not always get a stiffer coupling.
  bounded(2 * profile.friction_mn.value * 1'000'000 / profile.resolution_nm.value,
          CouplingLimit::kFriction);
  bounded(profile.max_stiffness_mn_per_mm.value, CouplingLimit::kStructure);
  return out;
}

Result<DeviceProfile> AtRate(const DeviceProfile& profile, int64_t rate_hz) {
  if (rate_hz < 100 || rate_hz > 20'000) {
    return Status(Code::kInvalidInput,
                  "loop rate: expected 100 to 20000 Hz, found " + std::to_string(rate_hz),
                  "rate_hz");
  }
  const std::string why = "for " + std::to_string(rate_hz) + " Hz";
  DeviceProfile out = profile;
  // First the rate and the delay at it, then what they allow: both are in the limits below.
  out.rate_hz = {rate_hz, "chosen"};
  const int64_t from_hz = profile.rate_hz.value;
  // At its own rate a profile keeps the source of its delay word for word.
  if (rate_hz != from_hz && profile.bus_delay_ticks.value > 0) {
    out.bus_delay_ticks = {DelayTicksAt(profile.bus_delay_ticks.value, from_hz, rate_hz),
                           why + ", the same time: " + profile.bus_delay_ticks.source};
  }
  const LargestCoupling largest = LargestCouplingAt(out, rate_hz, out.bus_delay_ticks.value);
  if (largest.coupling_mn_per_mm < 1) {
    return Status(Code::kInvalidInput,
                  "device profile '" + profile.name + "': no coupling is passive at " +
                      std::to_string(rate_hz) + " Hz: its " + CouplingLimitName(largest.limit) +
                      " allows none",
                  "coupling_mn_per_mm");
  }
  out.coupling_mn_per_mm = {
      largest.coupling_mn_per_mm,
      why + ", the largest that its " + CouplingLimitName(largest.limit) + " allows"};
  if (out.torque) {
    // Nothing is known of the wrist's structure: never stiffer than the profile says.
    const int64_t turning = PassiveTorque_un_m_per_rad(out, rate_hz, out.bus_delay_ticks.value);
    Sourced& k = out.torque->coupling_un_m_per_rad;
    if (turning < 1) {
      return Status(Code::kInvalidInput,
                    "device profile '" + profile.name + "': no torque is passive at " +
                        std::to_string(rate_hz) + " Hz: take a profile without torque",
                    "coupling_un_m_per_rad");
    }
    if (turning < k.value) k = {turning, why + ", the largest that its damping allows"};
  }
  return out;
}

}  // namespace enamel::scene
