#include "tests/station/sdk/fake_sdk.h"

#include <HD/hd.h>
#include <dhdc.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace enamel::station::testing_support {

FakeSdk& FakeSdk::ForceDimension() {
  static FakeSdk fake;
  return fake;
}

FakeSdk& FakeSdk::OpenHaptics() {
  static FakeSdk fake;
  return fake;
}

}  // namespace enamel::station::testing_support

namespace {

using enamel::station::testing_support::FakeSdk;
using State = FakeSdk::State;

FakeSdk& Dhd() { return FakeSdk::ForceDimension(); }
FakeSdk& Hd() { return FakeSdk::OpenHaptics(); }

constexpr std::chrono::microseconds kBus{200};  // a read waits for its bus
thread_local std::string name;                  // what was last returned as text

}  // namespace

extern "C" {

int dhdOpen() {
  return Dhd().With([](State& s) { return s.there ? (++s.open, 0) : -1; });
}
int dhdClose(char) {
  return Dhd().With([](State& s) { return --s.open, 0; });
}
const char* dhdGetSystemName(char) {
  name = Dhd().Get().name;
  return name.empty() ? nullptr : name.c_str();
}
const char* dhdErrorGetLastStr() { return "no device found"; }
int dhdEnableForce(unsigned char on, char) {
  return Dhd().With([&](State& s) { return s.motors = on == DHD_ON, 0; });
}
int dhdGetPosition(double* x, double* y, double* z, char) {
  std::this_thread::sleep_for(kBus);
  return Dhd().With([&](State& s) {
    if (!s.there) return -1;
    *x = s.position[0];
    *y = s.position[1];
    *z = s.position[2];
    ++s.reads;
    return 0;
  });
}
int dhdGetButton(int, char) { return Dhd().Get().button ? DHD_ON : DHD_OFF; }
int dhdSetForce(double x, double y, double z, char) {
  return Dhd().With([&](State& s) {
    s.force = {x, y, z};
    ++s.writes;
    return s.there ? 0 : -1;
  });
}

bool dhdHasWrist(char) { return Dhd().Get().wrist; }
bool dhdHasActiveWrist(char) { return Dhd().Get().wrist; }
int dhdGetOrientationFrame(double matrix[3][3], char) {
  const State s = Dhd().Get();
  for (size_t i = 0; i < 3; ++i) std::copy(s.frame[i].begin(), s.frame[i].end(), matrix[i]);
  return s.there ? 0 : -1;
}
int dhdSetForceAndTorque(double x, double y, double z, double tx, double ty, double tz, char) {
  return Dhd().With([&](State& s) {
    s.force = {x, y, z};
    s.torque = {tx, ty, tz};
    ++s.writes;
    return s.there ? 0 : -1;
  });
}

HHD hdInitDevice(const char*) {
  return Hd().With([](State& s) { return s.there ? (++s.open, HHD{0}) : HD_INVALID_HANDLE; });
}
void hdDisableDevice(HHD) {
  Hd().With([](State& s) { --s.open; });
}
void hdMakeCurrentDevice(HHD) {}
void hdBeginFrame(HHD) {}
void hdEndFrame(HHD) {}
const char* hdGetString(int) {
  name = Hd().Get().name;
  return name.empty() ? nullptr : name.c_str();
}
void hdGetDoublev(int, HDdouble* out) {
  std::this_thread::sleep_for(kBus);
  Hd().With([&](State& s) {
    std::copy(s.position.begin(), s.position.end(), out);
    ++s.reads;
  });
}
void hdGetIntegerv(int, HDint* out) { *out = Hd().Get().button ? HD_DEVICE_BUTTON_1 : 0; }
void hdSetDoublev(int, const HDdouble* in) {
  Hd().With([&](State& s) {
    std::copy(in, in + 3, s.force.begin());
    ++s.writes;
  });
}
void hdEnable(int) {
  Hd().With([](State& s) { s.motors = true; });
}
void hdStartScheduler() {}
HDErrorInfo hdGetError() { return {Hd().Get().there ? 0u : 1u}; }

}  // extern "C"
