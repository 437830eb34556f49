#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/base/fd.h"
#include "common/base/result.h"

// Device files below /dev: their kinds, and who may open them. Thread safety: functions, any thread.
// Real-time: never.
namespace enamel::station {

// A kind of device file, by the names that give a right to it.
struct NodeKind {
  std::string_view path;       // what its files begin with; AppArmor's rule
  std::string_view subsystem;  // in a rule of udev
  std::string_view allowed;    // in a unit's DeviceAllow, after "char-": its name in /proc/devices
};
inline constexpr NodeKind kHidrawNode{"/dev/hidraw", "hidraw", "hidraw"};
inline constexpr NodeKind kAcmNode{"/dev/ttyACM", "tty", "ttyACM"};
inline constexpr NodeKind kUsbNode{"/dev/bus/usb/", "usb", "usb_device"};

// What a driver opens. A test compares these with the unit, the udev rules and the AppArmor profile in
// station/ops.
struct DeviceNode {
  const NodeKind* kind;
  // What its USB ids begin with: "1451:", "0403:cb48"; empty: any, for which a school writes its own rule.
  std::string_view ids;
};

// Opens a device file for reading and writing, not waiting. Errors: kUnavailable with what to do; the
// field tells a missing udev rule (kPermission) from a unit that does not list the kind (kConfined), a
// device that another program uses (kInUse), and one that is away (kNotAttached).
Result<std::unique_ptr<Fd>> OpenNode(const std::string& path);

// Whether OpenNode can open it now. Opens the file and closes it again, which moves nothing.
Status WhyNotOpenable(const std::string& path);

// For tests: what OpenNode calls from now on in place of open(2), which it resembles; null: open(2).
using OpenCall = int (*)(const char* path, int flags);
void SetOpenCall(OpenCall call);

}  // namespace enamel::station
