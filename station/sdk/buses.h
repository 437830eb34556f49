#pragma once

#include <memory>

#include "common/base/result.h"
#include "station/devices/polled_device.h"

// One function per SDK, defined where it was found.
namespace enamel::station::sdk {

Result<std::unique_ptr<PolledBus>> OpenForceDimension();
Result<std::unique_ptr<PolledBus>> OpenOpenHaptics();

}  // namespace enamel::station::sdk
