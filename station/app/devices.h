#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

struct DevicesCommand {
  std::filesystem::path data;  // the station's folder: what was measured here
  bool all = false;            // also HID devices that are nothing known here
  std::filesystem::path json;
};

// Prints what is attached over HID, what each is taken for, its profile, how to name it and whether
// its delay was measured here, and the devices that are always there. Needs no rights: what may not
// be opened is said, with what to do. Errors: `json` cannot be written.
Status ListDevices(const DevicesCommand& options);

}  // namespace enamel::station
