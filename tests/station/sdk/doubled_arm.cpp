#include "tests/station/sdk/doubled_arm.h"

#include <dlfcn.h>

#include <cmath>
#include <thread>
#include <utility>

#include "common/base/check.h"

namespace enamel::station::testing_support {
namespace {

constexpr std::chrono::microseconds kBus{200};  // an exchange
// A read of a line that was cut hangs for so long.
constexpr std::chrono::milliseconds kHangs{10};
constexpr int kByWatchdog = 3;
// Nobody published how long a Touch that hears nothing keeps its force.
constexpr int kAssumedWatchdog_us = 20'000;

}  // namespace

DoubledArm::DoubledArm(const std::string& driver, const std::string& name) : driver_(driver) {
  state_.name = !name.empty() ? name : is_dhd() ? "omega.3" : "PHANTOM Desktop";
  if (!is_dhd()) {
    state_.watchdog_us = kAssumedWatchdog_us;
    state_.frame = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};  // its stylus points down
  }
  void* library = ::dlopen(is_dhd() ? "libdhd.so.3" : "libHD.so.3.4", RTLD_NOW | RTLD_LOCAL);
  ENAMEL_CHECK(library != nullptr);
  set_ = reinterpret_cast<SetBehindLibrary>(::dlsym(library, kSetBehindLibrary));
  ENAMEL_CHECK(set_ != nullptr);
  set_(this);
}

DoubledArm::~DoubledArm() { set_(nullptr); }

// Both frames have their up: Force Dimension's z in m, OpenHaptics' y in mm.
void DoubledArm::Lower(int steps) {
  With([&](State& s) { s.position[is_dhd() ? 2 : 1] = -(is_dhd() ? 40e-6 : 40e-3) * steps; });
}

void DoubledArm::Unplug() {
  With([](State& s) { s.there = false; });
}

void DoubledArm::Plug() {
  With([&](State& s) {
    s.serial -= std::exchange(is_other_, false);
    s.there = true;
    s.motors = false;
  });
}

bool DoubledArm::PlugOther() {
  With([&](State& s) {
    s.serial += !std::exchange(is_other_, true);
    s.there = true;
    s.motors = false;
  });
  return true;
}

std::array<int, 3> DoubledArm::told() const {
  std::lock_guard lock(mutex_);
  Lapse();
  return state_.motors ? told_ : std::array<int, 3>{};
}

DoubledArm::State DoubledArm::Get() const {
  std::lock_guard lock(mutex_);
  Lapse();
  return state_;
}

void DoubledArm::Lapse() const {
  // On a busy computer the station's thread may wait for longer: only a line that was cut is silent.
  if (!is_cut() || !state_.motors || state_.watchdog_us == 0) return;
  if (Clock::now() - fed_ <= std::chrono::microseconds(state_.watchdog_us)) return;
  state_.motors = false;
  state_.off_cause = kByWatchdog;
}

const char* DoubledArm::Open() {
  std::lock_guard lock(mutex_);
  if (!state_.there) return "no device found";
  if (state_.open > 0) return "device in use";
  ++state_.open;
  return nullptr;
}

void DoubledArm::Close() {
  With([](State& s) { --s.open; });
}

BehindLibrary::Facts DoubledArm::facts() { return Get(); }

BehindLibrary::Line DoubledArm::Read(Pose& out) {
  ++requests_;
  if (is_dhd()) std::this_thread::sleep_for(kBus);
  std::unique_lock lock(mutex_);
  if (!state_.there) return Line::kGone;
  if (Through(Bytes(1)).empty()) {
    lock.unlock();
    if (is_cut()) std::this_thread::sleep_for(kHangs);
    return Line::kSilent;
  }
  out = state_;
  if (is_garbled()) {
    for (double& x : out.position) x = std::ldexp(static_cast<int32_t>(random_()), -8);
  }
  ++state_.reads;
  return Line::kHere;
}

BehindLibrary::Line DoubledArm::Write(const std::array<double, 3>& force,
                                      const std::array<double, 3>& torque) {
  std::lock_guard lock(mutex_);
  if (!state_.there) return Line::kGone;
  if (is_cut()) return Line::kSilent;
  Lapse();
  fed_ = Clock::now();
  state_.force = force;
  state_.torque = torque;
  ++state_.writes;
  for (size_t i = 0; i < 3; ++i) told_[i] = static_cast<int>(std::lround(force[i] * 1e3));
  return Line::kHere;
}

void DoubledArm::SwitchMotors(bool on) {
  With([&](State& s) {
    s.motors = on;
    s.off_cause = 0;
    fed_ = Clock::now();
  });
}

void DoubledArm::SetWatchdog(int us) {
  With([&](State& s) { s.watchdog_us = us; });
}

void DoubledArm::EmulateButton(bool on) {
  With([&](State& s) { s.button_by_gripper = on; });
}

}  // namespace enamel::station::testing_support
