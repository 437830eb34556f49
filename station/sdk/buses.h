#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "station/devices/polled_device.h"

// Two functions per SDK, defined if the SDK was found. Open switches the motors on; Find only asks
// for the attached device's name.
namespace enamel::station::sdk {

Result<std::unique_ptr<PolledBus>> OpenForceDimension();
std::optional<std::string> FindForceDimension();
Result<std::unique_ptr<PolledBus>> OpenOpenHaptics();
std::optional<std::string> FindOpenHaptics();

}  // namespace enamel::station::sdk
