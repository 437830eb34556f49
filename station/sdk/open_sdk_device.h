#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "station/devices/polled_device.h"

namespace enamel::station::sdk {

// Whether a choice on the command line is one of ours: "dhd", "openhaptics".
bool IsSdkDevice(std::string_view choice);

// Opens it on a thread of its own. Errors: kInvalidInput for another choice, kUnavailable when this
// program was built without that SDK, or the library finds no device.
Result<std::unique_ptr<Device>> OpenSdkDevice(std::string_view choice,
                                              const scene::DeviceProfile& profile,
                                              std::function<void()> thread_setup = {});

}  // namespace enamel::station::sdk
