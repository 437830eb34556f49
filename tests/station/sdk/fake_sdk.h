#pragma once

#include <array>
#include <mutex>
#include <string>

namespace enamel::station::testing_support {

// Two makers' libraries without a device, linked in place of the real ones: the values each would
// read, and the commands it received. In its own frame and units. Thread safety: all of it.
class FakeSdk {
 public:
  struct State {
    bool there = false;  // attached
    std::string name;
    std::array<double, 3> position{}, force{}, torque{};
    std::array<std::array<double, 3>, 3> frame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // by rows
    bool wrist = false;  // sensed and driven
    bool button = false;
    bool motors = false;
    int open = 0;  // handles
    unsigned reads = 0, writes = 0;
  };

  static FakeSdk& ForceDimension();
  static FakeSdk& OpenHaptics();

  void Reset() { Set({}); }
  void Set(const State& state) {
    std::lock_guard lock(mutex_);
    state_ = state;
  }
  State Get() {
    std::lock_guard lock(mutex_);
    return state_;
  }
  // Changes it in one go.
  template <typename Change>
  auto With(Change change) {
    std::lock_guard lock(mutex_);
    return change(state_);
  }

 private:
  std::mutex mutex_;
  State state_;
};

}  // namespace enamel::station::testing_support
