#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "station/lab/devices/emulated_inverse3.h"
#include "tests/station/sdk/doubled_arm.h"
#include "tests/station/sdk/emulated_arms.h"
#include "tests/station/sdk/emulated_falcon.h"

namespace enamel::station::testing_support {

// The drivers whose devices are emulated.
inline constexpr const char* kArmDrivers[] = {
    "dhd", "openhaptics", "woodenhaptics", "polhem", "polhem_serial", "inverse3", "falcon"};

inline std::unique_ptr<EmulatedArm> MakeArm(const std::string& driver) {
  if (driver == "polhem_serial") return std::make_unique<EmulatedSerialArm>();
  if (driver == "inverse3") return std::make_unique<lab::EmulatedInverse3>();
  if (driver == "falcon") return std::make_unique<EmulatedFalcon>();
  if (driver == "dhd" || driver == "openhaptics") return std::make_unique<DoubledArm>(driver);
  return std::make_unique<EmulatedHidArm>(driver == "polhem");
}

// Of another thread's doing; within ten seconds.
inline void AwaitThat(const std::function<bool()>& reached) {
  for (int i = 0; i < 100'000 && !reached(); ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  ASSERT_TRUE(reached());
}

}  // namespace enamel::station::testing_support
