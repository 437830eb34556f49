#pragma once

#include <cstdint>
#include <optional>

#include "common/scene/calibration.h"
#include "common/scene/types.h"

// The device's own Coulomb friction c, as an attempt leaves it out of the force that it asks of the motors
// (common/haptics/README.md, "What the wish leaves out").
// Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

// Where nobody measured c, half of it is left out in tissue whose B/Kc is this long. Chosen: with a true c of half or
// twice the profile's, 1 of 4 608 strokes is felt worse by more than a point than with nothing left out. Four times
// as long makes more of them worse, a tenth gains little: tests/station/lab/laws/friction_test.cpp.
inline constexpr int32_t kUnmeasuredHalf_us = 40'000;

// A measured c counts if half the width of its 95 % interval is at most this share of it.
inline constexpr int64_t kMostUncertainty_percent = 15;

// c for attempts on a unit with this calibration, mN: the lower end of its interval, so that c left out is
// not more than there is. None: not measured, or not well enough.
std::optional<int64_t> FrictionOf(const Calibration& calibration);

// The profile of a unit whose c was measured. Kc is lowered to what that friction carries (cell.h), and never
// raised. A device whose board runs the spring keeps its profile where its friction does not carry the
// board's Kc: nobody can lower that here. Requires: friction_mn above 0.
DeviceProfile WithFriction(const DeviceProfile& profile, int64_t friction_mn);

}  // namespace enamel::scene
