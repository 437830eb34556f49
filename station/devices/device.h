#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/base/check.h"
#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station {

// Buttons and pedals as bits of DeviceSample::buttons.
enum DeviceButtons : uint8_t {
  kPedal = 1 << 0,   // pressed: the bur turns
  kFinish = 1 << 1,  // the operator has put the handpiece down: end of the attempt
};

// What the device said about one tick.
struct DeviceSample {
  std::array<int32_t, 3> counts{};  // encoder cells from the device's centre, scene axes
  QuantisedOrientation orientation = kIdentityOrientation;
  uint8_t buttons = 0;  // DeviceButtons
  uint16_t bur_speed_krpm = 0;
  bool fresh = true;  // false: nothing new since the last tick (stall)
};

// A haptic device, seen from the tick loop. One call of ReadSample and one of SendForce per tick,
// from one thread. Real-time: all methods but construction are safe: adapters of buses that block
// keep a thread of their own and exchange the newest values here.
class Device {
 public:
  virtual ~Device() = default;

  virtual std::string Name() const = 0;
  ENAMEL_REALTIME virtual DeviceSample ReadSample() noexcept = 0;
  // Force on the operator, N, scene frame; held until the next call. Zero before the first.
  ENAMEL_REALTIME virtual void SendForce(const dvec3& force_n) noexcept = 0;
  // The bur as the picture shows it now. Only a simulated operator looks.
  ENAMEL_REALTIME virtual void ShowBur(const dvec3& tip_m) noexcept { (void)tip_m; }
};

}  // namespace enamel::station
