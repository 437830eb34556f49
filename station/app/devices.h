#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

struct DevicesCommand {
  bool all = false;  // also HID devices that are nothing known here
  std::filesystem::path json;
};

// Prints what is attached over HID, what each is taken for, its profile and how to name it, and the
// devices that are always there. Needs no rights: what may not be opened is said, with what to do.
// Errors: `json` cannot be written.
Status ListDevices(const DevicesCommand& options);

}  // namespace enamel::station
