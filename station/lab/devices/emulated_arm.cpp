#include "station/lab/devices/emulated_arm.h"

namespace enamel::station::lab {

std::array<int, 3> EmulatedArm::told() const {
  std::lock_guard lock(mutex_);
  return told_;
}

void EmulatedArm::CutAfter(size_t bytes) {
  std::lock_guard lock(mutex_);
  left_ = bytes;
}

void EmulatedArm::Delay(std::chrono::microseconds delay, std::chrono::microseconds jitter) {
  std::lock_guard lock(mutex_);
  delay_ = delay;
  jitter_ = jitter;
}

std::chrono::microseconds EmulatedArm::Wait() {
  std::lock_guard lock(mutex_);
  return delay_ + std::chrono::microseconds(
                      std::uniform_int_distribution<int64_t>(0, jitter_.count())(random_));
}

Bytes EmulatedArm::Through(Bytes answer) {
  if (mute_) return {};
  if (garble_) {
    for (uint8_t& byte : answer) byte = static_cast<uint8_t>(random_());
  }
  if (answer.size() > left_) {
    answer.resize(left_);
    cut_ = true;
  }
  if (left_ != SIZE_MAX) left_ -= answer.size();
  return answer;
}

}  // namespace enamel::station::lab
