#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/base/result.h"
#include "common/hands/hand.h"
#include "common/math/orientation.h"
#include "common/math/vec.h"
#include "common/scene/delay.h"

namespace enamel::station {

// Buttons and pedals as bits of DeviceSample::buttons.
enum DeviceButtons : uint8_t {
  kPedal = 1 << 0,    // pressed: the bur turns
  kFinish = 1 << 1,   // the hand has nothing left to do: end of the attempt (simulated ones only)
  kPutDown = 1 << 2,  // the handpiece lies in its holder: no force and no bur meanwhile
  kSecond = 1 << 3,   // held: the hand's motion turns the picture, the bur is off (HeldDevice)
};

// Free speed of a handpiece that does not report it: a dental turbine's.
inline constexpr uint16_t kTurbineSpeed_krpm = 300;

// The device's report for one tick.
struct DeviceSample {
  std::array<int32_t, 3> counts{};  // encoder cells from the device's centre, scene axes
  QuantisedOrientation orientation = kIdentityOrientation;
  uint8_t buttons = 0;  // DeviceButtons
  uint16_t bur_speed_krpm = 0;
  bool fresh = true;     // false: nothing new since the last tick (stall)
  bool attached = true;  // false: unplugged, or never there; the pose is the last one known
  // False: the device has switched off its force by itself (its watchdog, its motors).
  bool driven = true;
  // The device's own sample number and clock. The clock never goes back: it stops while the device
  // is away or restarts. 0 if the device has none.
  uint32_t sequence = 0;
  uint64_t device_time_us = 0;
  // Of a spring that the device's board runs: its rest point, nm from where the counts are 0, scene
  // axes, and the share of its stiffness that is felt, 65 535 = all.
  std::array<int32_t, 3> rest_nm{};
  uint16_t share = 65'535;
  // The device's axes lie otherwise in the scene than in the last sample (HeldDevice): the tip has
  // jumped, and nobody's hand moved it there.
  bool turned = false;
};

// To a board that runs the spring (schemas/hid_haptic_report.md, report 0x47), scene axes.
struct SpringCommand {
  bool on = false, follow = false;
  std::array<int32_t, 3> rest_nm{};
  dvec3 added_n{0}, torque_n_m{0};
  double bound_n = 0;
};

// An adapter's counts for its bus since construction. All zero for a device without one.
struct DeviceCounters {
  uint64_t samples = 0;     // taken
  uint64_t lost = 0;        // missing in the sequence
  uint64_t duplicated = 0;  // a sequence number repeated or older: left out
  uint64_t refused = 0;     // too short, wrong id or version, failed check: left out
  uint64_t writes = 0;      // forces written
  uint64_t write_errors = 0;
  uint64_t detached = 0;  // times it was unplugged
};

// A haptic device, seen from the tick loop. One call of ReadSample and one of SendForceAndTorque
// per tick, from one thread. Real-time: ReadSample, the Sends and ShowBur are safe. Adapters of
// buses that block have their own threads and exchange the newest values with the tick
// (TripleBuffer).
class Device {
 public:
  virtual ~Device() = default;

  virtual std::string Name() const = 0;
  // Identifies the unit, so that its measurements are found again: "hid:1209:0001:SERIAL". Empty if
  // it is indistinguishable from others of its model, or not attached.
  virtual std::string Unit() const { return {}; }
  // What holds the tool, for the recording's header. A device that wraps another one returns that
  // one's.
  virtual Hand hand() const = 0;
  ENAMEL_REALTIME virtual DeviceSample ReadSample() noexcept = 0;
  // Force on the operator, N, scene frame, without torque; held until the next call. Zero before
  // the first.
  ENAMEL_REALTIME virtual void SendForce(const dvec3& force_n) noexcept = 0;
  // As SendForce, with a torque, N m, scene axes; the loop calls this. A device without rotational
  // motors ignores the torque.
  ENAMEL_REALTIME virtual void SendForceAndTorque(const dvec3& force_n,
                                                  const dvec3& torque_n_m) noexcept {
    (void)torque_n_m;
    SendForce(force_n);
  }
  // Its board runs the coupling's spring. Then SendSpring, in place of the Sends above, drives it in an
  // attempt whose core leaves the spring to the board (core::CoreParams::spring_on_board); a Send above
  // turns the spring off.
  virtual bool runs_spring() const noexcept { return false; }
  ENAMEL_REALTIME virtual void SendSpring(const SpringCommand& command) noexcept { (void)command; }
  // The bur as the picture shows it now. Only a simulated operator uses it.
  ENAMEL_REALTIME virtual void ShowBur(const dvec3& tip_m) noexcept { (void)tip_m; }

  // False: the force is shown, not felt (a mouse). Late ticks are then harmless.
  virtual bool has_motors() const noexcept { return true; }
  // How long the device must have been still before force comes on, at the start and after a fault,
  // s. 0 if it cannot hurt anybody.
  virtual double still_before_force_s() const noexcept { return 0; }
  // From any thread.
  virtual DeviceCounters counters() const noexcept { return {}; }
  // Why it cannot be reached at present, as a driver says it (trouble.h); ok: it answers, or nobody
  // knows. From any thread.
  virtual Status problem() const { return Status::Ok(); }
  // Of all answers so far, one that did not come counting as long as it was waited for. Nothing: the
  // device does not answer to forces. From any thread.
  virtual std::optional<scene::AnswerTime> answer_time() const noexcept { return {}; }
};

// A device whose motors take force and torque together.
class MotorDevice : public Device {
 public:
  ENAMEL_REALTIME void SendForce(const dvec3& force_n) noexcept final {
    SendForceAndTorque(force_n, dvec3(0));
  }
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override = 0;
  double still_before_force_s() const noexcept final { return 0.1; }
};

}  // namespace enamel::station
