#include "station/session/device_delay.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <thread>

#include "common/base/file.h"
#include "common/scene/own_friction.h"
#include "common/scene/plan.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// A calibration has some hundred bytes; another file of that name is not read whole.
constexpr size_t kMaxCalibration = 1 << 16;
// For answers of up to four ticks at 1 kHz, which the drivers wait for at most, every second one lost.
constexpr std::chrono::milliseconds kPatience{10 * kAnswersToKnow};
constexpr std::chrono::milliseconds kLookEvery{5};

// With the usual timer slack of 50 us a look each 150 us: 7 in a tick at 1 kHz.
constexpr std::chrono::microseconds kLookForPose{100};
constexpr int64_t kShortLook_ns = 250'000;
constexpr size_t kPosesToKnow = 250, kFewestPoses = 20;
constexpr std::chrono::milliseconds kWatchPoses{500};
// A look is off by up to its own length; the mean over so many poses by an eighth of that.
constexpr size_t kPosesInMean = 8;

int64_t Now_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

const char* FromText(scene::DelayUsed::From from) {
  switch (from) {
    case scene::DelayUsed::From::kProfile:
      return "its profile's, measured on a unit";
    case scene::DelayUsed::From::kCalibration:
      return "measured on this unit";
    case scene::DelayUsed::From::kAssumed:
      return "assumed";
    case scene::DelayUsed::From::kAnswers:
      return "more than was known, as its answers take now";
    case scene::DelayUsed::From::kPoses:
      return "more than was known, as its poses come more slowly than the ticks";
  }
  return "";
}

}  // namespace

fs::path CalibrationsFolder(const fs::path& data) { return data / "calibrations"; }

fs::path CalibrationFile(const fs::path& data, const std::string& unit) {
  // Makers write any text into a unit's name: no part of it may lead out of the folder.
  std::string name;
  for (char c : unit) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  // The hash distinguishes names that differ only in replaced letters.
  return CalibrationsFolder(data) /
         (name.substr(0, 60) + "-" + HashSha256(AsBytes(unit)).Hex().substr(0, 8) + ".json");
}

std::optional<scene::Calibration> FindCalibration(const fs::path& data, const std::string& unit) {
  if (unit.empty()) return std::nullopt;
  const fs::path file = CalibrationFile(data, unit);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  auto text = ReadFile(file, kMaxCalibration);
  auto read = text.ok() ? scene::CalibrationFromJson(AsText(*text))
                        : Result<scene::Calibration>(text.status());
  if (read.ok()) return std::move(*read);
  // Not an error: a device that counts as not measured is safe, only softer.
  spdlog::warn("{}: not a calibration that can be read, so {} counts as not measured: {}",
               file.string(), unit, read.status().message());
  return std::nullopt;
}

scene::DeviceProfile SilentProfile() {
  scene::DeviceProfile out;
  out.rate_hz.value = 1000;
  return out;
}

scene::DelayUsed DelayKnownHere(const fs::path& data, const std::string& unit,
                                const scene::DeviceProfile& profile,
                                const std::optional<scene::AnswerTime>& answers) {
  const auto calibration = FindCalibration(data, unit);
  return scene::DelayOfAttached(profile, calibration ? &*calibration : nullptr, 1000, answers);
}

std::optional<scene::AnswerTime> AwaitAnswerTime(const Device& device) {
  const auto until = std::chrono::steady_clock::now() + kPatience;
  auto found = device.answer_time();
  while (found && found->answers < kAnswersToKnow && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kLookEvery);
    found = device.answer_time();
  }
  return found && found->answers > 0 ? found : std::nullopt;
}

void PoseWatch::Look(int64_t now_ns, uint64_t poses) {
  const int64_t look_ns = now_ns - looked_ns_;
  const bool grew = began_ && poses > poses_;
  if (grew) {
    const bool sure = look_ns <= kShortLook_ns;
    // Poses in each of two short looks come faster than the looks. After a look without one, several came
    // at once.
    const auto count =
        static_cast<int64_t>(sure && grew_ ? std::min<uint64_t>(poses - poses_, 64) : 1);
    for (int64_t i = 1; i <= count; ++i)
      arrivals_.push_back({looked_ns_ + look_ns * i / count, sure});
  }
  grew_ = grew;
  poses_ = poses;
  looked_ns_ = now_ns;
  began_ = true;
}

std::optional<scene::PosePeriod> PoseWatch::period() const {
  const auto sure = static_cast<size_t>(std::ranges::count(arrivals_, true, &Arrival::sure));
  return PeriodOf(2 * sure >= arrivals_.size());
}

std::optional<scene::PosePeriod> PoseWatch::PeriodOf(bool only_sure) const {
  // Sorted times of `n` poses, each over n.
  const auto over = [&](size_t n) {
    std::vector<int64_t> out;
    for (size_t i = n; i < arrivals_.size(); ++i) {
      const Arrival &from = arrivals_[i - n], &to = arrivals_[i];
      if (only_sure && !(from.sure && to.sure)) continue;
      out.push_back((to.at_ns - from.at_ns) / static_cast<int64_t>(n));
    }
    std::ranges::sort(out);
    return out;
  };
  const std::vector<int64_t> each = over(1), means = over(kPosesInMean);
  if (each.size() + 1 < kFewestPoses || means.empty()) return std::nullopt;
  return scene::PosePeriod{means[means.size() / 2] / 1000,
                           each[(each.size() * 99 - 1) / 100] / 1000,
                           static_cast<int64_t>(each.size())};
}

std::optional<scene::PosePeriod> AwaitPosePeriod(const Device& device) {
  if (device.answer_time() || device.counters().samples == 0) return std::nullopt;
  PoseWatch watch;
  const auto until = std::chrono::steady_clock::now() + kWatchPoses;
  while (watch.arrivals() < kPosesToKnow && std::chrono::steady_clock::now() < until) {
    watch.Look(Now_ns(), device.counters().samples);
    std::this_thread::sleep_for(kLookForPose);
  }
  return watch.period();
}

DevicePace AwaitPace(const Device& device) {
  if (!device.has_motors()) return {};
  return {AwaitAnswerTime(device), AwaitPosePeriod(device)};
}

std::string AnswersText(const scene::AnswerTime& answers) {
  char text[120];
  std::snprintf(
      text, sizeof text, "99 of 100 answers within %.2f ms, half within %.2f: jitter %.2f ms",
      static_cast<double>(answers.p99_us) * 1e-3, static_cast<double>(answers.median_us) * 1e-3,
      static_cast<double>(answers.jitter_us()) * 1e-3);
  return text;
}

std::string DelayText(const scene::DelayUsed& used, const std::string& device) {
  const std::string ticks =
      std::to_string(used.ticks) + (used.ticks == 1 ? " tick" : " ticks") + " of delay";
  std::string answers;
  if (used.answers) {
    answers = " (" + AnswersText(*used.answers);
    if (used.calibrated_jitter_us) {
      char then[60];
      std::snprintf(then, sizeof then, ", %.2f ms when it was calibrated",
                    static_cast<double>(*used.calibrated_jitter_us) * 1e-3);
      answers += then;
    }
    answers += ")";
  }
  if (used.from == scene::DelayUsed::From::kPoses && used.poses) {
    char text[100];
    std::snprintf(text, sizeof text, " (one each %.2f ms, 99 of 100 within %.2f)",
                  static_cast<double>(used.poses->median_us) * 1e-3,
                  static_cast<double>(used.poses->p99_us) * 1e-3);
    answers += text;
  }
  if (used.from != scene::DelayUsed::From::kAssumed) {
    return device + ": " + ticks + ", " + FromText(used.from) + answers;
  }
  return device + ": its delay was never measured, so attempts assume " + ticks +
         " and its coupling is at most 2 b f/" +
         std::to_string((used.ticks + 1) * (used.ticks + 1)) + answers +
         "; 'enamel-station calibrate' measures it";
}

Status UseDelayOf(PreparedAttempt& prepared, const Device& device, const DevicePace& pace,
                  const fs::path& data) {
  // No force, so no delay can make it unstable.
  if (!device.has_motors()) return Status::Ok();
  const std::string name = device.Name();
  const auto calibration = FindCalibration(data, device.Unit());
  const int64_t rate_hz = prepared.header.params.rate_hz;
  const auto used = scene::DelayOfAttached(prepared.profile, calibration ? &*calibration : nullptr,
                                           rate_hz, pace.answers, pace.poses);
  const auto friction_mn = calibration ? scene::FrictionOf(*calibration) : std::nullopt;
  const scene::DeviceProfile unit =
      friction_mn ? scene::WithFriction(prepared.profile, *friction_mn) : prepared.profile;
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::WithDelay(unit, rate_hz, used.ticks));
  const int64_t was = prepared.header.params.kc_mn_per_mm, is = profile.coupling_mn_per_mm.value;
  // The chunks of a resumed attempt are chained to its header, and its ticks must replay with it: a
  // device that needs less stiffness or more guard is refused.
  if (prepared.core) {
    if (was > is) {
      return Status(Code::kConflict,
                    DelayText(used, name) + ": Kc is at most " + std::to_string(is) +
                        " mN/mm on it, and this attempt was begun with " + std::to_string(was) +
                        ": resume it on the device it was begun on, or close it",
                    "coupling_mn_per_mm");
    }
    const int64_t turning = profile.torque ? profile.torque->coupling_un_m_per_rad.value : 0;
    if (prepared.header.params.peak_torque_un_m > 0 &&
        prepared.header.params.rotational_kc_un_m_per_rad > turning) {
      return Status(Code::kConflict,
                    DelayText(used, name) + ": the torque's K is at most " +
                        std::to_string(turning) +
                        " uN m/rad on it, and this attempt was begun with " +
                        std::to_string(prepared.header.params.rotational_kc_un_m_per_rad) +
                        ": resume it on the device it was begun on, or close it",
                    "coupling_un_m_per_rad");
    }
    const uint32_t begun = prepared.header.params.bus_delay_ticks;
    if (begun < static_cast<uint32_t>(used.ticks)) {
      return Status(Code::kConflict,
                    DelayText(used, name) + ", and this attempt was begun with a guard for " +
                        std::to_string(begun) +
                        ": resume it on the device it was begun on, or close it",
                    "bus_delay_ticks");
    }
    // Motors that push with more friction than this unit has would drive the hand.
    const core::CoreParams& begun_with = prepared.header.params;
    if (begun_with.friction_measured && friction_mn.value_or(0) < begun_with.friction_mn[0]) {
      return Status(
          Code::kConflict,
          name +
              (friction_mn ? ": it has " + std::to_string(*friction_mn) + " mN of friction"
                           : ": its friction was not measured") +
              ", and this attempt was begun on a device with " +
              std::to_string(begun_with.friction_mn[0]) +
              " mN, which the motors push against: resume it on the device it was begun "
              "on, or close it",
          "friction_mn");
    }
    // A device that could take more keeps the attempt's settings, which are stable on it.
    prepared.delay = used;
    return Status::Ok();
  }
  const auto params = scene::CompilePlan(prepared.scene, prepared.exercise, profile);
  if (!params.ok() && params.status().field() == "bus_delay_ticks") {
    return Status(params.status().code(),
                  DelayText(used, name) + ", which is too late for an attempt (" +
                      params.status().message() + "): connect the device directly, or use another",
                  params.status().field());
  }
  ENAMEL_RETURN_IF_ERROR(params.status());
  prepared.header.params = *params;
  prepared.delay = used;
  using From = scene::DelayUsed::From;
  const bool unknown =
      used.from == From::kAssumed || used.from == From::kAnswers || used.from == From::kPoses;
  spdlog::log(unknown ? spdlog::level::warn : spdlog::level::info, "{}: Kc {} mN/mm{}",
              DelayText(used, name), is,
              is < was ? " instead of the profile's " + std::to_string(was) : "");
  return Status::Ok();
}

}  // namespace enamel::station
