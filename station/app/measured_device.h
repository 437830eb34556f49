#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "station/devices/device.h"

// What 'calibrate' and 'first-hour' measure. Thread safety: none.
namespace enamel::station {

// How a command line names a simulated device: "simulated:PROFILE".
inline constexpr std::string_view kSimulated = "simulated:";

struct MeasuredDevice {
  std::unique_ptr<Device> device;
  scene::DeviceProfile profile;     // for comparison
  std::array<double, 3> count_m{};  // way per count, of the device's report
  std::string address;              // with the serial number
  bool real = false;                // false: its time passes with each ReadSample
};

// Opens an attached device with motors: "hid", "hid:VENDOR:PRODUCT" or a driver of the table. `profile`
// is a name or a file; empty: the device's own. Its threads ask for real-time rights. Errors: kInvalidInput
// for another choice; the driver's, FindProfile's.
Result<MeasuredDevice> OpenToMeasure(const std::string& choice, const std::string& profile,
                                     int rate_hz);

// The time of a loop that is paced by the clock. Real-time: SleepUntil is safe.
int64_t Now_ns();
// Until a time, not for a duration, so that one late tick does not move all later ones. Continues after
// signals.
void SleepUntil(int64_t due_ns);

}  // namespace enamel::station
