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
  kFriction,   // c/S: its friction pays for the tip's cell (cell.h)
  kStructure,  // K, the largest stiffness it shows stably
  kMode,  // m (2 pi f1/4)^2: hand and spring stay two octaves below its first resonance, where known
};
// "damping", "friction", "structure", "mode".
const char* CouplingLimitName(CouplingLimit limit);

// m (2 pi f1/4)^2, rounded down. Requires: profile.structural_mode_hz above 0.
int64_t ModeStiffness_mn_per_mm(const DeviceProfile& profile);

struct LargestCoupling {
  int64_t coupling_mn_per_mm = 0;
  CouplingLimit limit = CouplingLimit::kDamping;
};

// min(2 b f/(d + 1)^2, c/S, K, m (2 pi f1/4)^2), rounded down; of equal limits the first in that order.
// K is taken as the structure's, whatever the rate. Requires: rate_hz > 0, resolution above 0, delay_ticks in 0..kMaxDelay_ticks
// (delay.h).
LargestCoupling LargestCouplingAt(const DeviceProfile& profile, int64_t rate_hz,
                                  int64_t delay_ticks);
// Refuses a profile whose Kc is above that: names the clause, the largest Kc that would do, and what to
// change. Errors: kInvalidInput (field "coupling_mn_per_mm", or "friction_mn").
Status CheckCoupling(const DeviceProfile& profile, int64_t rate_hz, int64_t delay_ticks);

// The profile at `rate_hz`: Kc raised or lowered to the largest, the torque's K lowered where it
// has to be, the delay kept as a time and rounded up to whole ticks. The source of each changed
// number names the change. Whether the device's bus carries the rate is not known here. Errors:
// kInvalidInput (field "rate_hz") outside 100..20000 Hz; ("coupling_mn_per_mm",
// "coupling_un_m_per_rad") when less than 1 unit is left.
Result<DeviceProfile> AtRate(const DeviceProfile& profile, int64_t rate_hz);

}  // namespace enamel::scene
