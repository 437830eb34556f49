#include "common/scene/delay.h"

#include <algorithm>
#include <string>

#include "common/scene/own_friction.h"
#include "common/scene/plan.h"

namespace enamel::scene {
namespace {

DelayUsed DelayKnown(const DeviceProfile& profile, const Calibration* calibration,
                     int64_t rate_hz) {
  if (calibration != nullptr && calibration->bus_delay_ticks) {
    return {DelayTicksAt(calibration->bus_delay_ticks->value, calibration->rate_hz, rate_hz),
            DelayUsed::From::kCalibration,
            {}};
  }
  // A number that nobody measured may only make the coupling softer, never stiffer.
  const int64_t said = DelayTicksAt(profile.bus_delay_ticks.value, profile.rate_hz.value, rate_hz);
  if (profile.delay_measured) return {said, DelayUsed::From::kProfile, {}};
  return {std::max(said, kAssumedDelay_ticks), DelayUsed::From::kAssumed, {}};
}

}  // namespace

int64_t DelayTicksAt(int64_t ticks, int64_t from_hz, int64_t to_hz) {
  // Rounded up: too much delay costs stiffness, too little is no longer passive.
  return std::min((ticks * to_hz + from_hz - 1) / from_hz, kMaxDelay_ticks);
}

int64_t AnswerTicks(const AnswerTime& answers, int64_t rate_hz) {
  const auto ticks = [&](int64_t us) {
    return std::max<int64_t>(1, DelayTicksAt(us, 1'000'000, rate_hz));
  };
  return ticks(answers.p99_us) + ticks(answers.median_us) - 1;
}

int64_t StaleTicks(const PosePeriod& period, int64_t rate_hz) {
  const auto ticks = [&](int64_t us) { return DelayTicksAt(us, 1'000'000, rate_hz); };
  const int64_t half = ticks(period.median_us * 95 / 100) - 1;
  return std::max<int64_t>({half, ticks(period.p99_us) - 2, 0});
}

DelayUsed DelayOfAttached(const DeviceProfile& profile, const Calibration* calibration,
                          int64_t rate_hz, const std::optional<AnswerTime>& answers,
                          const std::optional<PosePeriod>& poses) {
  DelayUsed out = DelayKnown(profile, calibration, rate_hz);
  out.answers = answers;
  if (calibration != nullptr && calibration->answer_jitter_us) {
    out.calibrated_jitter_us = calibration->answer_jitter_us->value;
  }
  if (answers) {
    const int64_t behind = out.from == DelayUsed::From::kAssumed ? out.ticks - 1 : 0;
    const int64_t ticks = std::min(AnswerTicks(*answers, rate_hz) + behind, kMaxDelay_ticks);
    if (ticks > out.ticks) {
      out.ticks = ticks;
      out.from = DelayUsed::From::kAnswers;
    }
  }
  out.poses = poses;
  if (poses && StaleTicks(*poses, rate_hz) > 0) {
    out.ticks = std::min(out.ticks + StaleTicks(*poses, rate_hz), kMaxDelay_ticks);
    out.from = DelayUsed::From::kPoses;
  }
  return out;
}

SpringTime SpringTimeOf(const DeviceProfile& profile, int64_t rate_hz, int64_t delay_ticks) {
  if (!profile.board_spring) return {rate_hz, delay_ticks};
  return {profile.board_spring->rate_hz, profile.board_spring->delay_ticks};
}

int64_t PassiveCoupling_mn_per_mm(const DeviceProfile& profile, int64_t rate_hz,
                                  int64_t delay_ticks) {
  const SpringTime time = SpringTimeOf(profile, rate_hz, delay_ticks);
  // In integers: mN/mm = N/m, b in mN s/m.
  const int64_t held = time.delay_ticks + 1;
  return 2 * profile.viscous_mn_s_per_m() * time.rate_hz / (1000 * held * held);
}

int64_t PassiveTorque_un_m_per_rad(const DeviceProfile& profile, int64_t rate_hz,
                                   int64_t delay_ticks) {
  const int64_t held = delay_ticks + 1;
  return 2 * profile.torque->damping_un_m_s_per_rad.value * rate_hz / (held * held);
}

Result<DeviceProfile> WithDelay(const DeviceProfile& profile, int64_t rate_hz,
                                int64_t delay_ticks) {
  const int64_t passive = PassiveCoupling_mn_per_mm(profile, rate_hz, delay_ticks);
  if (passive < 1) {
    return Status(
        Code::kInvalidInput,
        "device profile '" + profile.name + "': with " + std::to_string(delay_ticks) +
            " ticks of delay and damping b = " + std::to_string(profile.viscous_mn_s_per_m()) +
            " mN s/m no coupling is passive at " + std::to_string(rate_hz) +
            " Hz: measure both with 'enamel-station calibrate'",
        "bus_delay_ticks");
  }
  DeviceProfile out = profile;
  out.bus_delay_ticks.value = delay_ticks;
  out.coupling_mn_per_mm.value = std::min(profile.coupling_mn_per_mm.value, passive);
  if (out.torque) {
    const int64_t turning = PassiveTorque_un_m_per_rad(profile, rate_hz, delay_ticks);
    if (turning < 1) {
      return Status(Code::kInvalidInput,
                    "device profile '" + profile.name + "': with " + std::to_string(delay_ticks) +
                        " ticks of delay and damping b_rot = " +
                        std::to_string(profile.torque->damping_un_m_s_per_rad.value) +
                        " uN m s/rad no torque is passive at " + std::to_string(rate_hz) +
                        " Hz: measure both, or take a profile without torque",
                    "damping_un_m_s_per_rad");
    }
    int64_t& k = out.torque->coupling_un_m_per_rad.value;
    k = std::min(k, turning);
  }
  return out;
}

Status CheckParams(const Scene& scene, const Exercise& exercise, const DeviceProfile& profile,
                   const core::CoreParams& params) {
  ENAMEL_ASSIGN_OR_RETURN(auto plain, CompilePlan(scene, exercise, profile));
  if (plain == params) return Status::Ok();
  const int32_t friction_mn = params.friction_mn[0];
  const bool calibrated = params.friction_measured && friction_mn > 0;
  const DeviceProfile unit = calibrated ? WithFriction(profile, friction_mn) : profile;
  if (auto delayed = WithDelay(unit, exercise.rate_hz, params.bus_delay_ticks); delayed.ok()) {
    auto planned = CompilePlan(scene, exercise, *delayed);
    if (planned.ok() && *planned == params) return Status::Ok();
  }
  return Status(Code::kConflict,
                "the core parameters are not those that exercise '" + exercise.name +
                    "' and device profile '" + profile.name +
                    "' give, with whatever delay and measured friction",
                "params");
}

}  // namespace enamel::scene
