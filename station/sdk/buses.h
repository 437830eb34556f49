#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/devices/device_node.h"
#include "station/devices/polled_device.h"
#include "station/sdk/open_sdk_device.h"

// Two functions per driver. Open switches the motors on, at force 0; Find lists what is attached, with
// what keeps it from being used, and fills in all but SdkDevice::choice.
namespace enamel::station::sdk {

// The device files of each driver. Haply's service opens its devices itself.
inline constexpr std::array kForceDimensionNodes{DeviceNode{&kUsbNode, "1451:"}};
// The Touch: a serial port, and since 2023 a HID device (both ids: sawSensablePhantom's README; hidraw:
// wangzivector/Touch_ROS_Server).
inline constexpr std::array kOpenHapticsNodes{DeviceNode{&kAcmNode, "2988:"},
                                              DeviceNode{&kAcmNode, "0301:2988"},
                                              DeviceNode{&kHidrawNode, "2988:"}};
inline constexpr std::array kMbedNodes{DeviceNode{&kHidrawNode, "1234:0006"}};
inline constexpr std::array kPolhemSerialNodes{DeviceNode{&kAcmNode, "16c0:"}};
inline constexpr std::array kFalconNodes{DeviceNode{&kUsbNode, "0403:cb48"}};

struct BusChoice {
  std::string address;  // which of several, as the driver says below; empty: the first
  double peak_n = 0;    // a longer force is shortened to this
  double reach_m = 0;   // of the tip from the middle of its workspace
  // How long Open waits where somebody has to move the device before it knows where it is.
  std::chrono::milliseconds for_hand{10'000};
  std::string profile;     // the device profile's name; empty: of any model
  bool has_pedal = false;  // so that a device without a button can be used
  // The unit to open, as PolledBus::Unit; empty or not attached: the first. Only inverse3 reads it.
  std::string unit;
};

// Through the maker's library. Address: the library's file, if the system's loader does not find it.
Result<std::unique_ptr<PolledBus>> OpenForceDimension(const BusChoice& choice);
std::vector<SdkDevice> FindForceDimension();
Status LoadForceDimension();  // whether the library can be loaded
Result<std::unique_ptr<PolledBus>> OpenOpenHaptics(const BusChoice& choice);
std::vector<SdkDevice> FindOpenHaptics();
Status LoadOpenHaptics();

// WoodenHaptics with reports of 8 bytes, Polhem with reports of 14, both HID 1234:0006; Polhem with lines
// of 64 bytes on a serial port. Address: VENDOR:PRODUCT[:SERIAL], or the port's file.
Result<std::unique_ptr<PolledBus>> OpenWoodenHaptics(const BusChoice& choice);
std::vector<SdkDevice> FindWoodenHaptics();
Result<std::unique_ptr<PolledBus>> OpenPolhem(const BusChoice& choice);
std::vector<SdkDevice> FindPolhem();
Result<std::unique_ptr<PolledBus>> OpenPolhemSerial(const BusChoice& choice);
std::vector<SdkDevice> FindPolhemSerial();

// Haply's Inverse3 through the maker's service. Address: HOST:PORT of the service; where it is empty,
// port 10001 of this computer. Find reads the service's inventory, which starts nothing on the device.
Result<std::unique_ptr<PolledBus>> OpenInverse3(const BusChoice& choice);
std::vector<SdkDevice> FindInverse3();
std::vector<SdkDevice> FindInverse3At(const std::string& address);

// Novint's Falcon. Address: the file of its firmware; where it is empty, /etc/enamel/falcon.bin. Open loads
// that if none runs, and waits until a person has moved its grip. Find asks whether firmware runs, with frames of force 0.
Result<std::unique_ptr<PolledBus>> OpenFalcon(const BusChoice& choice);
std::vector<SdkDevice> FindFalcon();
std::vector<SdkDevice> FindFalconWith(const std::string& firmware_file);

}  // namespace enamel::station::sdk
