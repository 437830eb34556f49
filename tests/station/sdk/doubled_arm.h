#pragma once

#include <array>
#include <chrono>
#include <string>

#include "station/lab/devices/emulated_arm.h"
#include "tests/station/sdk/doubles/behind_library.h"

namespace enamel::station::testing_support {

// A device behind a double of its maker's library, which the driver loads as it would the library itself.
// One of each driver at a time. Thread safety: all of it.
class DoubledArm final : public lab::EmulatedArm, private BehindLibrary {
 public:
  struct State : Pose, Facts {
    bool there = true;  // attached
    std::array<double, 3> force{}, torque{};
    int watchdog_us = 0;
    bool button_by_gripper = false;
    int open = 0;  // handles
    unsigned reads = 0, writes = 0;
  };

  // "dhd" or "openhaptics".
  explicit DoubledArm(const std::string& driver, const std::string& name = {});
  ~DoubledArm() override;
  std::string choice() const override { return driver_; }
  const char* profile() const override { return is_dhd() ? "omega3" : "phantom_desktop"; }
  void Lower(int steps) override;
  // Of a call.
  size_t answer_bytes() const override { return 1; }
  void Unplug() override;
  void Plug() override;
  bool PlugOther() override;
  std::array<int, 3> told() const override;

  State Get() const;
  // Changes it in one go.
  template <typename Change>
  void With(Change change) {
    std::lock_guard lock(mutex_);
    change(state_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool is_dhd() const { return driver_ == "dhd"; }
  const char* Open() override;
  void Close() override;
  Facts facts() override;
  Line Read(Pose& out) override;
  Line Write(const std::array<double, 3>& force, const std::array<double, 3>& torque) override;
  void SwitchMotors(bool on) override;
  void SetWatchdog(int us) override;
  void EmulateButton(bool on) override;
  void Lapse() const;  // under mutex_

  const std::string driver_;
  SetBehindLibrary set_;
  mutable State state_;
  bool is_other_ = false;    // under mutex_
  Clock::time_point fed_{};  // when the device had its last force
};

}  // namespace enamel::station::testing_support
