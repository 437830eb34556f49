#pragma once

#include <array>
#include <string>

#include "station/devices/device.h"

namespace enamel::station::desk {

// Checks a device before the first tick: it is attached, the pedal is up, and the handpiece rests.
// Pure: takes samples at any pace. Thread safety: none.
class StillnessCheck {
 public:
  static constexpr double kWanted_s = 0.7, kAllowed_m = 0.5e-3;

  explicit StillnessCheck(double resolution_m) : resolution_m_(resolution_m) {}

  void Look(const DeviceSample& sample, double now_s);
  bool passed() const { return share() >= 1; }
  double share() const;  // of the required time at rest, 0..1
  // What the person has to do, a key of the words; empty if they only have to wait.
  const std::string& wanted() const { return wanted_; }

 private:
  const double resolution_m_;
  std::array<int32_t, 3> at_{};
  double since_s_ = -1, now_s_ = 0;
  std::string wanted_;
};

}  // namespace enamel::station::desk
