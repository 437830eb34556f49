#pragma once

#include <array>
#include <atomic>

#include "common/base/triple_buffer.h"
#include "station/devices/device.h"
#include "station/hid/hid_reader.h"

// 3Dconnexion's six-axis mice. Two families of reports, distinguished by their length:
//
//   separate  id 1: translation, 3 x i16; id 2: rotation, 3 x i16   (SpaceNavigator, 046d)
//   combined  id 1: translation and rotation, 6 x i16               (SpaceMouse Wireless, 256f)
//   both      id 3: buttons, one bit each, lowest first
//
// Little-endian, full deflection 350, axes x to the right, y toward the user, z down; rotations
// right-handed about them. Other ids (battery 0x17, LED) do not concern the pose. Source: published
// report descriptors and recordings (usage page 1, usage 8, logical range -350 to 350).
namespace enamel::station::hid {

inline constexpr uint16_t kMultiAxisPage = 0x0001, kMultiAxisUsage = 0x0008;

struct SpaceMouseState {
  std::array<int16_t, 6> axes{};  // x y z rx ry rz
  uint32_t buttons = 0;

  bool AtRest() const noexcept { return axes == std::array<int16_t, 6>{}; }
  bool operator==(const SpaceMouseState&) const = default;
};

enum class SpaceMouseReport : uint8_t { kTaken, kIgnored, kTooShort };
// Applies a report to `state`; unchanged unless kTaken. Pure.
SpaceMouseReport TakeReport(ByteView report, SpaceMouseState& state) noexcept;

struct SpaceMouseSettings {
  HidMatch match{0, 0, {}, kMultiAxisPage, kMultiAxisUsage};
  double max_speed_m_per_s = 0.02;  // at full deflection
  double max_turn_rad_per_s = 1.0;
  double reach_m = 0.03;  // of the tip from the centre
};

// Velocity of tip (m/s) and tool (rad/s) in the scene, seen with x to the right, y away from the
// user and z up: zero up to 10, then growing with the square. Pure.
struct SpaceMouseMotion {
  dvec3 velocity_m_per_s{0}, turn_rad_per_s{0};
};
SpaceMouseMotion MotionOf(const SpaceMouseState& state,
                          const SpaceMouseSettings& settings) noexcept;

// The loop's device: deflection is speed. It has no motors. Button 1 is the pedal. A deflected
// mouse reports every few ms: after kSilence_s without a report it counts as released.
class SpaceMouse final : public Device, private ReportSink {
 public:
  static constexpr double kSilence_s = 0.25;

  // `resolution_m`: edge of a count. Errors: kNotFound, kUnavailable.
  static Result<std::unique_ptr<SpaceMouse>> Open(const SpaceMouseSettings& settings,
                                                  double resolution_m, double tick_s);

  std::string Name() const override { return name_; }
  Hand hand() const override { return MakeHand(HandKind::kPointer, name_, "spacemouse"); }
  bool has_motors() const noexcept override { return false; }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  ENAMEL_REALTIME void SendForce(const dvec3&) noexcept override {}
  DeviceCounters counters() const noexcept override;

 private:
  struct Message {
    SpaceMouseState state;
    bool attached = false;
    uint64_t number = 0;
  };

  SpaceMouse(const SpaceMouseSettings& settings, std::string name, double resolution_m,
             double tick_s);
  void OnReport(ByteView report) override;
  bool OnAttached(const HidInfo& info) override;
  void OnDetached() override;
  void Publish(bool attached);

  const SpaceMouseSettings settings_;
  const std::string name_;
  const double resolution_m_, tick_s_;
  TripleBuffer<Message> mailbox_;
  std::atomic<uint64_t> samples_{0}, refused_{0}, detached_{0};
  // Owned by the reader's thread.
  SpaceMouseState state_;
  uint64_t published_ = 0;
  // Owned by the tick.
  uint64_t seen_ = 0;
  double silent_s_ = 0;
  dvec3 at_m_{0};
  Quat orientation_;
  HidReader reader_;  // last: its thread uses the rest
};

}  // namespace enamel::station::hid
