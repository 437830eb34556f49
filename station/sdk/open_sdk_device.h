#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "station/devices/device_node.h"
#include "station/devices/polled_device.h"
#include "station/hid/open_device.h"

namespace enamel::station::sdk {

// An attached device of the table of drivers (open_sdk_device.cpp): of a maker's library, or of a protocol
// that is published.
struct SdkDevice {
  std::string choice;    // its driver, as a command line names it: "dhd", "polhem"
  std::string name;      // "omega.3"
  std::string profile;   // name of its device profile
  std::string ids;       // "1234:0006"; empty where the library does not say
  std::string unit;      // as Device::Unit
  Status problem;        // why it cannot be used now, and what to do; ok if it can
  bool answers = false;  // to forces, and only so: no maker's library switches its motors on
};

// Attached devices, in the table's order. Opens those of makers' libraries briefly
// without switching motors on: not while one is in use. Two drivers may both list a device whose ids are
// the same: its profile tells which. Thread safety: one at a time.
std::vector<SdkDevice> ListSdkDevices();

// What the device's profile does not know of it, and how to find out: "profile polhem_v1 asks for …". Empty
// if it knows all, or no such profile is built in.
std::string AskedForText(const SdkDevice& device);

// By choice.
std::vector<std::string> Drivers();

// The device files that a driver opens; none: it opens a connection to a service.
std::span<const DeviceNode> NodesOf(std::string_view choice);

// Whether the maker's library that a driver needs can be loaded. Errors: kUnavailable, with what to
// install.
Status CheckLibrary(std::string_view choice);

// Profile name of a model: its letters and digits in lower case, words joined by _. "omega.3" is
// omega3, "PHANTOM Desktop" is phantom_desktop.
std::string ProfileNameOf(std::string_view model);

// Whether a choice on the command line names a driver of the table: "dhd", "polhem_serial:/dev/ttyACM0".
bool IsSdkDevice(std::string_view choice);

// Opens the chosen device for an attempt, through a driver of the table or hid::OpenDevice, with the
// foot pedal if one was named. A choice of the table may be followed by ":ADDRESS" (buses.h). Errors: as
// hid::OpenDevice; kUnavailable when the maker's library is missing or too old, the device is not found, is
// used by another program, or is not calibrated.
Result<std::unique_ptr<Device>> OpenChosenDevice(const hid::DeviceChoice& choice,
                                                 const scene::DeviceProfile& profile,
                                                 double tick_s);

}  // namespace enamel::station::sdk
