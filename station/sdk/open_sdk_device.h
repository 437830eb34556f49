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

// A device that a maker's library has found.
struct SdkDevice {
  std::string choice;   // how a person names it: "dhd", "openhaptics"
  std::string name;     // as the library tells it: "omega.3"
  std::string profile;  // what its device profile is called: ProfileNameOf(name)
};

// Those that are attached, of the libraries this program was built with. Opens each for a moment to
// ask, without switching its motors on: not while one is in use. Thread safety: one at a time.
std::vector<SdkDevice> ListSdkDevices();

// The libraries this program was built with, by choice.
std::vector<std::string> BuiltIn();

// What a model's profile is called: its letters and digits in lower case, words joined by _.
// "omega.3" is omega3, "PHANTOM Desktop" is phantom_desktop.
std::string ProfileNameOf(std::string_view model);

// Whether a choice on the command line is one of ours: "dhd", "openhaptics".
bool IsSdkDevice(std::string_view choice);

// Opens what a person has chosen for an attempt, whoever drives it: a maker's library, else
// hid::OpenDevice; with the foot pedal if one was named. Errors: as hid::OpenDevice; kUnavailable
// when this program was built without that SDK, or the library finds no device.
Result<std::unique_ptr<Device>> OpenChosenDevice(const hid::DeviceChoice& choice,
                                                 const scene::DeviceProfile& profile,
                                                 double tick_s);

}  // namespace enamel::station::sdk
