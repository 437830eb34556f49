#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "station/devices/device.h"

namespace enamel::station::desk {

// A device that the window can pause. While paused the pedal counts as released, so the bur stops
// and the force fades as usual; poses continue, so the recording stays whole. The same while the
// device's second button is held: the hand turns the picture then.
//
// The window can also turn the device's axes about the scene's z by quarters, so that the hand's
// right stays the picture's right when somebody looks from another side. Quarters are exact in
// counts: the cells of the device's positions stay what its profile says. An orientation is rounded
// once more (kMinRotationCell_urad), which nothing but the picture and the cut sees: a device that
// gives torque must not be turned, nor one whose board runs the spring.
//
// Thread safety: SetPaused, SetQuarters, own_counts, speed_krpm and turns_view from any thread, the rest as
// Device. Real-time as Device.
class HeldDevice final : public Device {
 public:
  // `inner` outlives this.
  explicit HeldDevice(Device& inner) : inner_(inner) {}

  void SetPaused(bool paused) noexcept { paused_.store(paused, std::memory_order_relaxed); }
  // Quarter turns of the device's axes in the scene, counter-clockwise from above. They hold from the
  // next sample without the bur on; that sample is marked as turned, unless it is the first.
  void SetQuarters(int quarters) noexcept {
    wanted_quarters_.store(static_cast<unsigned>(quarters) & 3u, std::memory_order_relaxed);
  }
  // As the device counted last, not turned.
  std::array<int32_t, 3> own_counts() const noexcept {
    return {own_counts_[0].load(std::memory_order_relaxed),
            own_counts_[1].load(std::memory_order_relaxed),
            own_counts_[2].load(std::memory_order_relaxed)};
  }
  // The device's second button is down.
  bool turns_view() const noexcept { return turns_view_.load(std::memory_order_relaxed); }
  // Speed of the unloaded handpiece; 0 while the pedal is up.
  int speed_krpm() const noexcept { return speed_krpm_.load(std::memory_order_relaxed); }

  std::string Name() const override { return inner_.Name(); }
  std::string Unit() const override { return inner_.Unit(); }
  Hand hand() const override { return inner_.hand(); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override {
    DeviceSample sample = inner_.ReadSample();
    for (size_t i = 0; i < own_counts_.size(); ++i) {
      own_counts_[i].store(sample.counts[i], std::memory_order_relaxed);
    }
    const bool second = (sample.buttons & kSecond) != 0;
    turns_view_.store(second, std::memory_order_relaxed);
    if (second || paused_.load(std::memory_order_relaxed)) {
      sample.buttons &= static_cast<uint8_t>(~kPedal);
      sample.bur_speed_krpm = 0;
    }
    bool turning = (sample.buttons & kPedal) != 0;
    speed_krpm_.store(turning ? sample.bur_speed_krpm : 0, std::memory_order_relaxed);
    Turn(sample, turning);
    return sample;
  }
  ENAMEL_REALTIME void SendForce(const dvec3& force_n) noexcept override {
    inner_.SendForce(FromScene(force_n));
  }
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override {
    inner_.SendForceAndTorque(FromScene(force_n), FromScene(torque_n_m));
  }
  bool runs_spring() const noexcept override { return inner_.runs_spring(); }
  ENAMEL_REALTIME void SendSpring(const SpringCommand& command) noexcept override {
    inner_.SendSpring(command);
  }
  ENAMEL_REALTIME void ShowBur(const dvec3& tip_m) noexcept override { inner_.ShowBur(tip_m); }
  bool has_motors() const noexcept override { return inner_.has_motors(); }
  double still_before_force_s() const noexcept override { return inner_.still_before_force_s(); }
  DeviceCounters counters() const noexcept override { return inner_.counters(); }
  Status problem() const override { return inner_.problem(); }
  std::optional<scene::AnswerTime> answer_time() const noexcept override {
    return inner_.answer_time();
  }

 private:
  void Turn(DeviceSample& sample, bool bur_on) noexcept;
  dvec3 FromScene(const dvec3& v) const noexcept;

  Device& inner_;
  std::atomic<bool> paused_{false}, turns_view_{false};
  std::atomic<unsigned> wanted_quarters_{0};
  std::array<std::atomic<int32_t>, 3> own_counts_{};
  // Owned by the tick.
  unsigned quarters_ = 0;
  bool read_ = false;
  std::atomic<int> speed_krpm_{0};
};

}  // namespace enamel::station::desk
