// OpenHaptics' HDAPI without a device: exported as published, with the device that a test puts behind it.
// Its scheduler has a thread of its own, and only that thread may open a frame.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "tests/station/sdk/doubles/behind_library.h"

namespace {

using enamel::station::testing_support::BehindLibrary;
using Line = BehindLibrary::Line;

constexpr unsigned int kNoHandle = 0xFFFFFFFF, kDeviceFault = 0x0300, kAlreadyInitiated = 0x0301,
                       kCommError = 0x0302, kIllegalBegin = 0x0400, kForceError = 0x0201;

struct Info {
  unsigned int code;
  int internal;
  unsigned int device;
};
using Callback = unsigned int (*)(void*);

std::atomic<BehindLibrary*> device{nullptr};
std::atomic<unsigned int> error{0};
thread_local std::string text;
thread_local bool is_servo = false;

std::mutex mutex;
Callback callback = nullptr;
void* data = nullptr;
std::atomic<bool> runs{false};
std::thread scheduler;

// Of the frame that is open.
BehindLibrary::Pose pose;
std::array<double, 3> force{};
bool is_here = false;

void RunScheduler() {
  is_servo = true;
  while (runs) {
    {
      std::lock_guard lock(mutex);
      if (callback != nullptr && callback(data) == 0) callback = nullptr;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

extern "C" {

void EnamelSetBehindLibrary(BehindLibrary* behind) { device = behind; }

unsigned int hdInitDevice(const char*) {
  const char* why = device == nullptr ? "no device" : device.load()->Open();
  if (why == nullptr) return 0;
  error = device != nullptr && device.load()->facts().motors ? kAlreadyInitiated : kDeviceFault;
  return kNoHandle;
}
void hdDisableDevice(unsigned int) { device.load()->Close(); }
void hdMakeCurrentDevice(unsigned int) {}
void hdBeginFrame(unsigned int) {
  if (!is_servo) {
    error = kIllegalBegin;
    return;
  }
  // A silent line holds the servo loop up.
  Line line;
  while ((line = device.load()->Read(pose)) == Line::kSilent && runs) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  is_here = line == Line::kHere;
  if (line == Line::kGone) error = kCommError;
}
void hdEndFrame(unsigned int) {
  if (is_here && device.load()->Write(force, {}) == Line::kGone) error = kCommError;
  if (is_here && !device.load()->facts().motors) error = kForceError;
}
const char* hdGetString(unsigned int what) {
  const BehindLibrary::Facts facts = device.load()->facts();
  text = what == 0x2501 ? facts.name : what == 0x2504 ? std::to_string(facts.serial) : "";
  return text.empty() ? nullptr : text.c_str();
}
void hdGetDoublev(unsigned int what, double* out) {
  if (what != 0x2052) std::abort();
  for (size_t column = 0; column < 3; ++column) {
    for (size_t row = 0; row < 3; ++row) out[4 * column + row] = pose.frame[row][column];
    out[4 * column + 3] = 0;
  }
  std::copy(pose.position.begin(), pose.position.end(), out + 12);
  out[15] = 1;
}
void hdGetIntegerv(unsigned int what, int* out) {
  *out = what == 0x2000 ? (pose.button ? 1 : 0) + (pose.second ? 2 : 0) : what == 0x2555 ? 4 : 0;
}
void hdSetDoublev(unsigned int what, const double* in) {
  if (what == 0x2700) std::copy(in, in + 3, force.begin());
}
void hdEnable(unsigned int what) {
  if (what == 0x4000) device.load()->SwitchMotors(true);
}
void hdDisable(unsigned int what) {
  if (what == 0x4000) device.load()->SwitchMotors(false);
}
void hdStartScheduler() {
  if (runs.exchange(true)) return;
  scheduler = std::thread(RunScheduler);
}
void hdStopScheduler() {
  runs = false;
  if (scheduler.joinable()) scheduler.join();
}
unsigned long hdScheduleAsynchronous(Callback called, void* with, unsigned short) {
  std::lock_guard lock(mutex);
  callback = called;
  data = with;
  return 1;
}
void hdUnschedule(unsigned long) {
  std::lock_guard lock(mutex);
  callback = nullptr;
}
Info hdGetError() { return {error.exchange(0), 0, 0}; }
const char* hdGetErrorString(unsigned int) { return "no device found"; }
unsigned int hdCheckCalibration() { return device.load()->facts().calibrated ? 0x5000 : 0x5002; }
void hdUpdateCalibration(unsigned int) {}

}  // extern "C"
