#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/types.h"
#include "station/devices/device.h"
#include "station/hid/haptic_report.h"
#include "station/hid/hid_port.h"

// From what a person writes on the command line or in the settings to a device that runs, and back:
// from what is attached to what it is taken for.
namespace enamel::station::hid {

enum class HidKind : uint8_t { kOther, kHapticBoard, kSpaceMouse, kFootPedal };
// By usage page and ids alone: nothing is opened.
HidKind Recognise(const HidInfo& info);
const char* HidKindText(HidKind kind);  // "haptic board", …
// How a person names it: "hid:1209:0001:SERIAL", "spacemouse:256f:c62e", "05f3:00ff" for a pedal.
std::string DeviceNameOf(const HidInfo& info);

// Why this program may not open it, and what to do about it; empty when it may. Nothing is opened.
std::string WhyNotUsable(const HidInfo& info);

struct DeviceChoice {
  // "hid" or "spacemouse", the first that is there; or either with ":VENDOR:PRODUCT[:SERIAL]".
  std::string device;
  std::string pedal;            // as ParsePedal reads it; empty: the device's own button
  std::string axes = "+x+y+z";  // of a haptic board, as ParseAxisMap reads it
  int watchdog_ms = 20;
  // A haptic board's two threads call it when they begin: gives them the loop's priority.
  std::function<void()> thread_setup;
};

// Opens it for an attempt with this profile. Errors: kInvalidInput for a choice that names nothing,
// kNotFound, kUnavailable, kVersion, kConflict when the board is not what the profile says.
Result<std::unique_ptr<Device>> OpenDevice(const DeviceChoice& choice,
                                           const scene::DeviceProfile& profile, double tick_s);

// The device with a foot pedal, as ParsePedal reads it; as it is when `pedal` is empty.
// Errors: kInvalidInput, kNotFound, kUnavailable.
Result<std::unique_ptr<Device>> WithPedal(std::unique_ptr<Device> device, const std::string& pedal);

// Asks a haptic board what it is. Errors: kUnavailable, kVersion, kInvalidInput.
Result<FeatureReport> AskBoard(const HidInfo& info);

}  // namespace enamel::station::hid
