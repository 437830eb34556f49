#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/delay.h"
#include "station/devices/device.h"
#include "station/session/prepared_attempt.h"

// The delay of an attached device, as known on this station, and attempts computed with it.
// Simulated devices and mice have no unknown delay: their profile's applies. Thread safety:
// functions, any thread; may read files. Real-time: never.
namespace enamel::station {

// Folder under the station's where `calibrate` keeps each unit's newest measurement.
std::filesystem::path CalibrationsFolder(const std::filesystem::path& data);
// File of a unit's measurement there. `unit`: Device::Unit(), not empty.
std::filesystem::path CalibrationFile(const std::filesystem::path& data, const std::string& unit);
// The newest measurement of this unit, if there is one and `unit` is not empty. An unreadable file
// counts as none, and is logged as a warning.
std::optional<scene::Calibration> FindCalibration(const std::filesystem::path& data,
                                                  const std::string& unit);

// How long the device's answers take: when it has answered kAnswersToKnow times, or given fewer within a
// few seconds, what it has. Nothing: it does not answer to a force. Blocks meanwhile.
inline constexpr int64_t kAnswersToKnow = 500;
std::optional<scene::AnswerTime> AwaitAnswerTime(const Device& device);

// Finds how long a device takes from pose to pose from looks at its count of poses. Looks of at most
// 250 us tell when a pose came; a longer one, when the computer was busy, tells nothing, unless most are:
// then this computer's timer is the slow part, and a loop has no better one.
class PoseWatch {
 public:
  // Times and counts only grow.
  void Look(int64_t now_ns, uint64_t poses);
  size_t arrivals() const { return arrivals_.size(); }
  // Nothing with fewer than 20 arrivals.
  std::optional<scene::PosePeriod> period() const;

 private:
  // A time at which the count had grown.
  struct Arrival {
    int64_t at_ns = 0;
    bool sure = false;
  };
  std::optional<scene::PosePeriod> PeriodOf(bool only_sure) const;

  std::vector<Arrival> arrivals_;
  int64_t looked_ns_ = 0;
  uint64_t poses_ = 0;
  bool began_ = false, grew_ = false;  // grew: in the last look
};

// How often a device that sends its poses by itself does so: of 250 poses, or of half a second. Nothing:
// it answers instead (answer_time), counts no poses, or sends none. Blocks meanwhile.
std::optional<scene::PosePeriod> AwaitPosePeriod(const Device& device);

// How an attached device keeps time.
struct DevicePace {
  std::optional<scene::AnswerTime> answers;
  std::optional<scene::PosePeriod> poses;
};
// Both of the above. Nothing at all of a device without motors, of which nobody needs them. Blocks meanwhile.
DevicePace AwaitPace(const Device& device);

// A profile at 1 kHz that says nothing of a delay.
scene::DeviceProfile SilentProfile();
// The delay for attempts on this unit with this profile, at 1 kHz.
scene::DelayUsed DelayKnownHere(const std::filesystem::path& data, const std::string& unit,
                                const scene::DeviceProfile& profile = SilentProfile(),
                                const std::optional<scene::AnswerTime>& answers = {});

// "99 of 100 answers within 0.09 ms, half within 0.05: jitter 0.04 ms".
std::string AnswersText(const scene::AnswerTime& answers);
// One sentence for doctor, devices, the log and the operator. If Kc was lowered: by how much and
// why, and what to do if nobody measured the delay. If it was measured: its value and source.
std::string DelayText(const scene::DelayUsed& used, const std::string& device);

// Before the ticket is taken: compiles the attempt's parameters again with the delay of `device`, which keeps
// this pace, and with the friction that its calibration measured (scene/own_friction.h). Notes the delay in
// `prepared.delay`. Applies to devices with motors that are not simulated; others
// are left unchanged. Logged, as a warning if nobody measured. A resumed attempt keeps its original
// parameters. Errors: WithDelay's; kConflict when a resumed attempt is stiffer than this device
// allows.
Status UseDelayOf(PreparedAttempt& prepared, const Device& device, const DevicePace& pace,
                  const std::filesystem::path& data);

}  // namespace enamel::station
