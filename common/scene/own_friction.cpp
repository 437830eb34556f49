#include "common/scene/own_friction.h"

#include <algorithm>

#include "common/scene/cell.h"

namespace enamel::scene {

std::optional<int64_t> FrictionOf(const Calibration& calibration) {
  if (!calibration.friction_mn) return std::nullopt;
  const Measured& c = *calibration.friction_mn;
  if (c.uncertainty * 100 > c.value * kMaxUncertainty_percent) return std::nullopt;
  // Both were rounded.
  const int64_t low = c.value - c.uncertainty - 1;
  return low > 0 ? std::optional(low) : std::nullopt;
}

DeviceProfile WithFriction(const DeviceProfile& profile, int64_t friction_mn) {
  const int64_t carried = friction_mn * 1'000'000 / CellSupportNm(profile);
  const bool lower = carried < profile.coupling_mn_per_mm.value;
  if (carried < 1 || (lower && profile.board_spring)) return profile;
  DeviceProfile out = profile;
  out.friction_mn.value = friction_mn;
  out.friction_measured = out.friction_of_unit = true;
  if (lower) out.coupling_mn_per_mm.value = carried;
  return out;
}

}  // namespace enamel::scene
