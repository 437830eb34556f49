#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

struct DevicesCommand {
  std::filesystem::path data;  // the station's folder with its measurements
  bool all = false;            // also unknown HID devices
  std::filesystem::path json;
};

// Lists HID devices and the devices that are always available. Prints each one's kind, profile,
// name for --device and whether its delay was measured here. Needs no rights: for a device that may
// not be opened it prints what to do. Errors: `json` cannot be written.
Status ListDevices(const DevicesCommand& options);

}  // namespace enamel::station
