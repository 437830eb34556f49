#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "station/devices/polled_device.h"
#include "station/hid/open_device.h"

namespace enamel::station::sdk {

// A device found by a maker's library.
struct SdkDevice {
  std::string choice;   // name on the command line: "dhd", "openhaptics"
  std::string name;     // from the library: "omega.3"
  std::string profile;  // name of its device profile: ProfileNameOf(name)
};

// Attached devices of the libraries built in. Opens each briefly without switching its motors on:
// not while one is in use. Thread safety: one at a time.
std::vector<SdkDevice> ListSdkDevices();

// The libraries this program was built with, by choice.
std::vector<std::string> BuiltIn();

// Profile name of a model: its letters and digits in lower case, words joined by _. "omega.3" is
// omega3, "PHANTOM Desktop" is phantom_desktop.
std::string ProfileNameOf(std::string_view model);

// Whether a choice on the command line is an SDK's: "dhd", "openhaptics".
bool IsSdkDevice(std::string_view choice);

// Opens the chosen device for an attempt, through a maker's library or hid::OpenDevice, with the
// foot pedal if one was named. Errors: as hid::OpenDevice; kUnavailable when this program was built
// without that SDK, or the library finds no device.
Result<std::unique_ptr<Device>> OpenChosenDevice(const hid::DeviceChoice& choice,
                                                 const scene::DeviceProfile& profile,
                                                 double tick_s);

}  // namespace enamel::station::sdk
