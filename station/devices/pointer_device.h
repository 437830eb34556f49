#pragma once

#include <cstdint>

#include "common/base/triple_buffer.h"
#include "station/devices/device.h"

// Mouse and keyboard as a device: the mouse moves the tip in a plane of the scene, the wheel moves
// it across the plane, a key is the pedal, four keys tilt the bur.
//
//   window thread: input events ─▶ PointerMapping ─ pose ─▶ PointerDevice::Publish
//   tick thread:                              latest value ─▶ PointerDevice::ReadSample
//
// A mouse has no motors: the force is computed, recorded and shown, not felt. To press, one draws
// the tip into the tooth, and the coupling's spring presses.
namespace enamel::station {

// The pose the hand intends.
struct PointerPose {
  dvec3 offset_m{0};  // tip from the device's centre, scene axes
  Quat orientation;   // scene from bur
  uint8_t buttons = 0;
};

struct PointerSettings {
  double reach_m = 0.03;         // of the tip from the centre
  double wheel_step_m = 0.1e-3;  // one notch
  double fine_ratio = 0.2;       // of all motion, while the fine key is held
  double tilt_rad_per_s = 0.8;
  double max_tilt_rad = 1.05;  // 60 degrees, about each axis
  dvec3 start_m{0};            // tip at the start and after Recall, within reach
};

// Turns events into a pose. A pure function of its calls. The mouse moves in the plane of two scene
// axes that faces the viewer most (seen from above: mesio-distal and bucco-lingual), so the wheel
// is the depth; forward is away from the viewer. Thread safety: none. Real-time: safe.
class PointerMapping {
 public:
  explicit PointerMapping(const PointerSettings& settings = {});

  // The view: unit directions in the scene frame, to the right on the screen and from the scene
  // toward the viewer, and the size of a pixel at the point in view. The pose does not change. A
  // direction that is zero or not finite is ignored.
  void SetView(const dvec3& right, const dvec3& toward_viewer, double m_per_px);

  // Cursor moved: x to the right, y down, as window systems report it.
  void MoveBy(double dx_px, double dy_px);
  // Wheel: positive is forward, away from the operator, and moves the tip away from the viewer.
  void Wheel(double notches);
  void SetFine(bool held) { fine_ = held; }
  void SetPedal(bool down) { SetButton(kPedal, down); }
  // Which tilt keys are held, -1, 0 or 1 each: the shank leans right on the screen, and away.
  void SetTilt(int right, int away);
  // Advances time for held keys. Takes at most 0.1 s: the window may have hung.
  void Advance(double dt_s);
  // Upright again.
  void Straighten() { lean_right_rad_ = lean_away_rad_ = 0; }
  // Releases all keys: a window without the focus does not see their release.
  void ReleaseKeys();
  // Back at the start, upright. Not while the pedal is down: the bur would cut its way there.
  void Recall();

  PointerPose pose() const;

 private:
  void SetButton(uint8_t button, bool down);
  void Shift(const dvec3& by_m);

  const PointerSettings settings_;
  dvec3 right_{1, 0, 0}, up_{0, 1, 0}, toward_{0, 0, 1};  // of the plane, right-handed
  double m_per_px_ = 20e-6;
  dvec3 offset_m_;
  double lean_right_rad_ = 0, lean_away_rad_ = 0;
  int tilt_right_ = 0, tilt_away_ = 0;
  bool fine_ = false;
  uint8_t buttons_ = 0;
};

// The loop's device. Poses are published 60 times a second. In between, the tip follows through two
// first-order filters of kLag_s each, at kMaxSpeed_m_per_s at most, so that the bur moves without
// jumps. A window that has not published for kSilence_s counts as hanging: the pedal is then
// released, since nobody sees the cut.
//
// Thread safety: Publish by one thread, the rest by the tick's. Before the first Publish the tip is
// at the start, the pedal up.
class PointerDevice final : public Device {
 public:
  static constexpr double kLag_s = 0.015, kMaxSpeed_m_per_s = 0.1, kSilence_s = 0.5;

  // `resolution_m`: edge of a count, of the device profile. Requires: both > 0.
  // `start_m`: of the tip, from the centre.
  PointerDevice(double resolution_m, double tick_s, const dvec3& start_m = dvec3(0));

  // Latest value wins. Wait-free.
  void Publish(const PointerPose& pose) noexcept;

  std::string Name() const override { return "mouse and keyboard"; }
  Hand hand() const override { return MakeHand(HandKind::kPointer, Name(), "mouse"); }
  bool has_motors() const noexcept override { return false; }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  ENAMEL_REALTIME void SendForce(const dvec3&) noexcept override {}

 private:
  struct Message {
    PointerPose pose;
    uint64_t number = 0;
  };

  const double resolution_m_, tick_s_, share_;  // share_: of the way per tick, for each filter
  TripleBuffer<Message> mailbox_;
  uint64_t published_ = 0;  // owned by the publisher
  // Owned by the tick.
  uint64_t seen_ = 0;
  double silent_s_ = 0;
  dvec3 first_m_, at_m_;
  Quat first_, orientation_;
};

}  // namespace enamel::station
