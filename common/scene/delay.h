#pragma once

#include <cstdint>
#include <optional>

#include "common/base/result.h"
#include "common/core/params.h"
#include "common/scene/calibration.h"
#include "common/scene/types.h"

// How many ticks of delay an attempt is computed with, and what its coupling may be then. A bus, a
// thread hop and an amplifier are between a force and its effect, and a coupling that is passive
// without delay pumps with a tick of it (common/haptics/README.md, "With delay"). Thread safety:
// functions, any thread. Real-time: not safe.
namespace enamel::scene {

// A device whose delay nobody measured is taken to have this many ticks.
inline constexpr int64_t kAssumedDelay_ticks = 1;
// More than any profile may say makes no coupling worth having.
inline constexpr int64_t kMaxDelay_ticks = 100;

// How long a device that answers each force with its pose takes for it: half of its answers, and 99 of
// 100. What is above the half is jitter.
struct AnswerTime {
  int64_t median_us = 0, p99_us = 0, answers = 0;
  // Half the width of each one's 95 % interval.
  int64_t median_half_us = 0, p99_half_us = 0;

  int64_t jitter_us() const { return p99_us - median_us; }

  bool operator==(const AnswerTime&) const = default;
};

// The delay of such a device, ticks, at least one: from the tick that asks to the one that reads the answer,
// for 99 of 100 answers, and the ticks beyond one for which the force is held until the next answer, for
// half of them. A device whose answers all take n ticks ends the force for a pose 2 n ticks after it was
// read, which is d + 1.
int64_t AnswerTicks(const AnswerTime& answers, int64_t rate_hz);

// How long a device that sends its poses by itself takes from one to the next: half of them, and 99 of 100.
struct PosePeriod {
  int64_t median_us = 0, p99_us = 0, poses = 0;

  bool operator==(const PosePeriod&) const = default;
};

// Ticks beyond one that a pose of it is used for: the force answers a pose that is older by as much.
// ceil(period/tick) - 1, with 5 % off the median for clocks that differ, and a tick off the 99th
// percentile: the loop counts a single late pose itself (LoopCounters::leak_j).
int64_t StaleTicks(const PosePeriod& period, int64_t rate_hz);

struct DelayUsed {
  enum class From {
    kProfile,      // the profile's, measured on a unit
    kCalibration,  // measured on this unit, by `enamel-station calibrate`
    kAssumed,      // nobody measured it: the profile's number, at least kAssumedDelay_ticks
    kAnswers,      // more than these say: its answers take longer now
    kPoses,        // these, and more on top: its poses come more slowly than the loop's ticks
  };
  int64_t ticks = 0;
  From from = From::kAssumed;
  std::optional<AnswerTime> answers;  // of a device that was timed
  // Of its answers, when this unit was calibrated.
  std::optional<int64_t> calibrated_jitter_us = {};
  std::optional<PosePeriod> poses = {};  // of a device that was watched

  bool operator==(const DelayUsed&) const = default;
};

// A delay in ticks of one rate as ticks of another: the same time, rounded up, at most
// kMaxDelay_ticks.
int64_t DelayTicksAt(int64_t ticks, int64_t from_hz, int64_t to_hz);

// The delay of a device that is attached, at `rate_hz`. A calibration of it, if there is one that
// measured the delay, comes first, then a profile that says it was measured. A delay measured at
// another rate is converted as a time, rounded up. `answers`, as they are now, only add: a measured delay
// has them as they were, an assumed one has one tick for them and the rest for what lies behind. `poses`
// come on top of all that (StaleTicks).
DelayUsed DelayOfAttached(const DeviceProfile& profile, const Calibration* calibration,
                          int64_t rate_hz, const std::optional<AnswerTime>& answers = {},
                          const std::optional<PosePeriod>& poses = {});

// The rate and the delay that the coupling's spring runs with: the board's where that runs it, else
// these of the loop and its bus.
struct SpringTime {
  int64_t rate_hz = 0, delay_ticks = 0;
};
SpringTime SpringTimeOf(const DeviceProfile& profile, int64_t rate_hz, int64_t delay_ticks);

// Largest Kc at the spring's time: 2 b f/(d + 1)^2, mN/mm, rounded down; b with the electrical damping.
// Requires: rate_hz > 0, delay_ticks in 0..kMaxDelay_ticks.
int64_t PassiveCoupling_mn_per_mm(const DeviceProfile& profile, int64_t rate_hz,
                                  int64_t delay_ticks);

// Largest torque stiffness K with this delay: 2 b_rot f/(d + 1)^2, uN m/rad, rounded down. Requires
// as above, and profile.torque.
int64_t PassiveTorque_un_m_per_rad(const DeviceProfile& profile, int64_t rate_hz,
                                   int64_t delay_ticks);

// The profile with this delay, and with Kc and the torque's K lowered to what is passive then;
// never raised. Its other numbers stay. Errors: kInvalidInput when less than 1 mN/mm or 1 uN m/rad
// is left, with what to do.
Result<DeviceProfile> WithDelay(const DeviceProfile& profile, int64_t rate_hz, int64_t delay_ticks);

// Checks the parameters of a recording: they must be those that CompilePlan gives for the unchanged
// profile (a simulated device, a mouse), or for WithDelay of it at their delay (an attached
// device), after WithFriction (own_friction.h) where the unit's friction was measured. Errors: CompilePlan's for the unchanged profile; kConflict (field "params").
Status CheckParams(const Scene& scene, const Exercise& exercise, const DeviceProfile& profile,
                   const core::CoreParams& params);

}  // namespace enamel::scene
