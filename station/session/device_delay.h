#pragma once

#include <filesystem>
#include <optional>
#include <string>

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

// The delay for attempts on this unit if its profile does not give a measured one: measured here at
// 1 kHz, else assumed.
scene::DelayUsed DelayKnownHere(const std::filesystem::path& data, const std::string& unit);

// One sentence for doctor, devices, the log and the operator. If Kc was lowered: by how much and
// why, and what to do if nobody measured the delay. If it was measured: its value and source.
std::string DelayText(const scene::DelayUsed& used, const std::string& device);

// Before the ticket is taken: compiles the attempt's parameters again with the delay of `device`
// and notes it in `prepared.delay`. Applies to devices with motors that are not simulated; others
// are left unchanged. Logged, as a warning if nobody measured. A resumed attempt keeps its original
// parameters. Errors: WithDelay's; kConflict when a resumed attempt is stiffer than this device
// allows.
Status UseDelayOf(PreparedAttempt& prepared, const Device& device,
                  const std::filesystem::path& data);

}  // namespace enamel::station
