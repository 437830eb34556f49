#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "station/devices/device.h"

namespace enamel::test {

// The first sample that satisfies the condition, or the last one after ten seconds, which fails the
// test.
template <typename Wanted>
station::DeviceSample AwaitSample(station::Device& device, const Wanted& wanted) {
  station::DeviceSample s = device.ReadSample();
  for (int i = 0; i < 10'000 && !wanted(s); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    s = device.ReadSample();
  }
  EXPECT_TRUE(wanted(s));
  return s;
}

}  // namespace enamel::test
