#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/scene/delay.h"
#include "station/devices/device.h"
#include "station/session/prepared_attempt.h"

// The delay of a device that is attached, from what is known of it here, and an attempt that is
// computed with it. A simulated device and a mouse have theirs by construction: they are left as
// their profile says.
// Thread safety: functions, any thread; may read files. Real-time: never.
namespace enamel::station {

// Where `calibrate` keeps the newest measurement of each unit, under the station's folder.
std::filesystem::path CalibrationsFolder(const std::filesystem::path& data);
// A measurement's file there. `unit`: Device::Unit(), not empty.
std::filesystem::path CalibrationFile(const std::filesystem::path& data, const std::string& unit);
// The newest measurement of this unit; none where there is none, and where `unit` is empty. What is
// there and cannot be read counts as none, and a warning is logged.
std::optional<scene::Calibration> FindCalibration(const std::filesystem::path& data,
                                                  const std::string& unit);

// The delay that attempts on this unit are computed with when its profile does not say more: by
// what was measured here, at 1 kHz, else assumed.
scene::DelayUsed DelayKnownHere(const std::filesystem::path& data, const std::string& unit);

// What was lowered and why, as a sentence, with what to do where nobody measured: for doctor,
// devices, the log and the operator. Of a delay that was measured: how large it is and by what.
std::string DelayText(const scene::DelayUsed& used, const std::string& device);

// Before the ticket is taken: the attempt's parameters are compiled again with the delay of
// `device`, which has motors and is no simulation (others: nothing happens), and `prepared.delay`
// says so; logged, as a warning where nobody measured. One that is resumed keeps the parameters it
// was begun with. Errors: WithDelay's; kConflict when a resumed one is stiffer than what this
// device allows.
Status UseDelayOf(PreparedAttempt& prepared, const Device& device,
                  const std::filesystem::path& data);

}  // namespace enamel::station
