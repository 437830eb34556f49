#pragma once

#include <memory>
#include <string>

#include "common/base/fd.h"
#include "common/base/result.h"

// Device files below /dev. Thread safety: functions, any thread. Real-time: never.
namespace enamel::station::sdk {

// Opens a device file as OpenNode does, for this program alone: OpenAlone refuses the file to a second
// station until the first closes it. Errors: as OpenNode.
Result<std::unique_ptr<Fd>> OpenAlone(const std::string& path);

// The USB socket that "/dev/hidraw3" or "/dev/ttyACM0" is plugged into: "1-2.3". It names a unit that
// has no serial number. Empty if the system does not say.
std::string UsbPlace(const std::string& path);
// Its ids as udev writes them: "16c0:0483". Empty as above.
std::string UsbIds(const std::string& path);

}  // namespace enamel::station::sdk
