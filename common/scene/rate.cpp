#include "common/scene/rate.h"

#include <string>

#include "common/scene/cell.h"
#include "common/scene/delay.h"

namespace enamel::scene {

const char* CouplingLimitName(CouplingLimit limit) {
  constexpr const char* kNames[] = {"damping", "friction", "structure", "mode"};
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
  bounded(profile.friction_mn.value * 1'000'000 / CellSupportNm(profile), CouplingLimit::kFriction);
  bounded(profile.max_stiffness_mn_per_mm.value, CouplingLimit::kStructure);
  if (!profile.structural_mode_hz.source.empty())
    bounded(ModeStiffness_mn_per_mm(profile), CouplingLimit::kMode);
  return out;
}

int64_t ModeStiffness_mn_per_mm(const DeviceProfile& profile) {
  // (2 pi/4)^2 = 2.4674 in integers; g Hz^2 = 1e-3 N/m.
  const int64_t f1 = profile.structural_mode_hz.value;
  return profile.mass_g.value * f1 * f1 / 1000 * 24'674 / 10'000;
}

Status CheckCoupling(const DeviceProfile& profile, int64_t rate_hz, int64_t delay_ticks) {
  const LargestCoupling largest = LargestCouplingAt(profile, rate_hz, delay_ticks);
  const int64_t kc = profile.coupling_mn_per_mm.value;
  if (kc <= largest.coupling_mn_per_mm) return Status::Ok();
  const SpringTime time = SpringTimeOf(profile, rate_hz, delay_ticks);
  const std::string at = " at " + std::to_string(time.rate_hz) + " Hz and " +
                         std::to_string(time.delay_ticks) + " ticks of delay" +
                         (profile.board_spring ? " of the board's spring" : "");
  std::string clause, instead;
  switch (largest.limit) {
    case CouplingLimit::kDamping:
      clause = "its damping carries, 2 b f/(d + 1)^2" + at;
      break;
    case CouplingLimit::kFriction: {
      const int64_t support = CellSupportNm(profile);
      clause =
          "its friction carries, c/S with S = " + std::to_string(support) + " nm of the tip's cell";
      instead = ", or c to at least " + std::to_string((kc * support + 999'999) / 1'000'000) +
                " mN if the device has it";
      break;
    }
    case CouplingLimit::kStructure:
      clause = "the device shows stably";
      break;
    case CouplingLimit::kMode:
      clause = "its first resonance carries, m (2 pi f1/4)^2";
      break;
  }
  return Status(Code::kInvalidInput,
                "device profile '" + profile.name +
                    "': coupling stiffness Kc = " + std::to_string(kc) + " mN/mm is above " +
                    std::to_string(largest.coupling_mn_per_mm) + " mN/mm, the largest that " +
                    clause + ": set Kc to at most " + std::to_string(largest.coupling_mn_per_mm) +
                    " mN/mm" + instead,
                largest.limit == CouplingLimit::kFriction ? "friction_mn" : "coupling_mn_per_mm");
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
  // A board's spring has its own rate and its own Kc.
  if (!out.board_spring) {
    out.coupling_mn_per_mm = {
        largest.coupling_mn_per_mm,
        why + ", the largest that its " + CouplingLimitName(largest.limit) + " allows"};
  }
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
