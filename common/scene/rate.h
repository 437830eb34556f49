#pragma once

#include <cstdint>

#include "common/base/result.h"
#include "common/scene/types.h"

// A device profile at another loop rate: a faster loop may have a stiffer coupling, up to what the
// device's friction and its structure bear.
// Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

// What keeps Kc from being larger.
enum class CouplingLimit {
  kDamping,    // 2 b f/(d + 1)^2: the device's damping pays for the spring's ticks
  kFriction,   // 2 c/delta: its friction pays for the encoder's cell
  kStructure,  // K, the largest stiffness it shows stably
};
// "damping", "friction", "structure".
const char* CouplingLimitName(CouplingLimit limit);

struct LargestCoupling {
  int64_t coupling_mn_per_mm = 0;
  CouplingLimit limit = CouplingLimit::kDamping;
};

// min(2 b f/(d + 1)^2, 2 c/delta, K), rounded down; of equal limits the first in that order. All
// three are proved or published for the unchanged profile; K is taken as the structure's, whatever
// the rate. Requires: rate_hz > 0, resolution above 0, delay_ticks in 0..kMostDelay_ticks
// (delay.h).
LargestCoupling LargestCouplingAt(const DeviceProfile& profile, int64_t rate_hz,
                                  int64_t delay_ticks);

// The profile at `rate_hz`: Kc raised or lowered to the largest, the torque's K lowered where it
// has to be, the delay kept as a time and rounded up to whole ticks. The source of each changed
// number names the change. Whether the device's bus carries the rate is not known here. Errors:
// kInvalidInput (field "rate_hz") outside 100..20000 Hz; ("coupling_mn_per_mm",
// "coupling_un_m_per_rad") when less than 1 unit is left.
Result<DeviceProfile> AtRate(const DeviceProfile& profile, int64_t rate_hz);

}  // namespace enamel::scene
