#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/types.h"
#include "station/devices/device.h"
#include "station/devices/device_node.h"
#include "station/hid/haptic_report.h"
#include "station/hid/hid_port.h"

// Opens the device that a command line or the settings name; and recognises and names attached
// devices.
namespace enamel::station::hid {

enum class HidKind : uint8_t { kOther, kHapticBoard, kSpaceMouse, kFootPedal };
// Uses only usage page and ids; opens nothing.
HidKind Recognise(const HidInfo& info);
const char* HidKindText(HidKind kind);  // "haptic board", …
// Its name on the command line: "hid:1209:0001:SERIAL", "spacemouse:256f:c62e", "05f3:00ff" for a
// pedal.
std::string DeviceNameOf(const HidInfo& info);

// The device files of boards, 6-DoF mice and pedals.
inline constexpr std::array kNodes{
    DeviceNode{&kHidrawNode, ""}, DeviceNode{&kHidrawNode, "046d:c6"},
    DeviceNode{&kHidrawNode, "256f:"}, DeviceNode{&kHidrawNode, "05f3:00ff"}};

// Whether the station can open it now: WhyNotOpenable of its file.
Status WhyNotUsable(const HidInfo& info);

struct DeviceChoice {
  // "hid" or "spacemouse", the first attached; or either with ":VENDOR:PRODUCT[:SERIAL]".
  std::string device;
  std::string pedal;            // as ParsePedal reads it; empty: the device's own button
  std::string axes = "+x+y+z";  // of a haptic board, as ParseAxisMap reads it
  int watchdog_ms = 20;
  // Called at the start of a haptic board's two threads, to give them the loop's priority.
  std::function<void()> thread_setup;
};

// Opens the device for an attempt with this profile. Errors: kInvalidInput for an unknown choice,
// kNotFound, kUnavailable, kVersion, kConflict when the board does not match the profile.
Result<std::unique_ptr<Device>> OpenDevice(const DeviceChoice& choice,
                                           const scene::DeviceProfile& profile, double tick_s);

// Adds a foot pedal, named as for ParsePedal, to the device; `pedal` empty: returns it unchanged.
// Errors: kInvalidInput, kNotFound, kUnavailable.
Result<std::unique_ptr<Device>> WithPedal(std::unique_ptr<Device> device, const std::string& pedal);

// Reads a haptic board's feature report. Errors: kUnavailable, kVersion, kInvalidInput.
Result<FeatureReport> AskBoard(const HidInfo& info);

}  // namespace enamel::station::hid
