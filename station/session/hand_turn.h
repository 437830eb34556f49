#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "station/devices/device.h"

// How an attached device is turned on its table, as the window measured it here: kept for each unit, or for all of
// a name where units have no number of their own (schemas/station_settings.md, "Measured at the chair"). Thread safety:
// functions, any thread; read and write files. Real-time: never.
namespace enamel::station {

// The degrees by which it stands turned, 0, 90, 180 or 270, counter-clockwise from above; `otherwise` where none
// was measured. A file that cannot be read counts as none, and is logged as a warning.
int HandTurnOf(const std::filesystem::path& data, const Device& device, int otherwise);

// Replaces it. Errors: those of WriteFileDurably.
Status KeepHandTurn(const std::filesystem::path& data, const Device& device, int turn_deg);

}  // namespace enamel::station
