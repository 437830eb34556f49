#pragma once

#include <cstdint>
#include <memory>

#include "station/devices/device.h"

namespace enamel::station {

// Buttons separate from the device: a foot pedal.
class ButtonSource {
 public:
  virtual ~ButtonSource() = default;
  virtual std::string Name() const = 0;
  // DeviceButtons pressed at the moment; none while it is unplugged. From any thread. Real-time:
  // safe.
  ENAMEL_REALTIME virtual uint8_t buttons() const noexcept = 0;
};

// A device with a separate pedal: a button is down when either reports it down.
class PedalledDevice final : public Device {
 public:
  // Neither may be null.
  PedalledDevice(std::unique_ptr<Device> device, std::unique_ptr<ButtonSource> pedal)
      : device_(std::move(device)), pedal_(std::move(pedal)) {
    ENAMEL_CHECK(device_ != nullptr && pedal_ != nullptr);
  }

  std::string Name() const override { return device_->Name() + ", pedal: " + pedal_->Name(); }
  std::string Unit() const override { return device_->Unit(); }
  Hand hand() const override { return device_->hand(); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override {
    DeviceSample sample = device_->ReadSample();
    sample.buttons |= pedal_->buttons();
    if ((sample.buttons & kPedal) != 0 && sample.bur_speed_krpm == 0) {
      sample.bur_speed_krpm = kTurbineSpeed_krpm;
    }
    return sample;
  }
  ENAMEL_REALTIME void SendForce(const dvec3& force_n) noexcept override {
    device_->SendForce(force_n);
  }
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override {
    device_->SendForceAndTorque(force_n, torque_n_m);
  }
  bool runs_spring() const noexcept override { return device_->runs_spring(); }
  ENAMEL_REALTIME void SendSpring(const SpringCommand& command) noexcept override {
    device_->SendSpring(command);
  }
  ENAMEL_REALTIME void ShowBur(const dvec3& tip_m) noexcept override { device_->ShowBur(tip_m); }
  bool has_motors() const noexcept override { return device_->has_motors(); }
  double still_before_force_s() const noexcept override { return device_->still_before_force_s(); }
  DeviceCounters counters() const noexcept override { return device_->counters(); }
  Status problem() const override { return device_->problem(); }
  std::optional<scene::AnswerTime> answer_time() const noexcept override {
    return device_->answer_time();
  }

 private:
  const std::unique_ptr<Device> device_;
  const std::unique_ptr<ButtonSource> pedal_;
};

}  // namespace enamel::station
