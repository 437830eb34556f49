#pragma once

#include <cstdint>
#include <optional>

#include "common/scene/calibration.h"
#include "common/scene/types.h"

// The device's own Coulomb friction c, as an attempt takes it out of the force in the hand
// (haptics/friction_relief.h).
// Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

// A measured c counts if half the width of its 95 % interval is at most this share of it.
inline constexpr int64_t kMaxUncertainty_percent = 15;

// c for attempts on a unit with this calibration, mN: the lower end of its interval, so that c left out is
// not more than there is. None: not measured, or not well enough.
std::optional<int64_t> FrictionOf(const Calibration& calibration);

// The profile of a unit whose c was measured. Kc is lowered to what that friction carries (cell.h), and never
// raised. A device whose board runs the spring keeps its profile where its friction does not carry the
// board's Kc: nobody can lower that here. Requires: friction_mn above 0.
DeviceProfile WithFriction(const DeviceProfile& profile, int64_t friction_mn);

}  // namespace enamel::scene
