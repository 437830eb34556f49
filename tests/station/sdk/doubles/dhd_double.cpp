// Force Dimension's library without a device: exported as published, with the device that a test puts
// behind it.
#include <algorithm>
#include <atomic>

#include "tests/station/sdk/doubles/behind_library.h"

namespace {

using enamel::station::testing_support::BehindLibrary;
using Line = BehindLibrary::Line;

std::atomic<BehindLibrary*> device{nullptr};
std::atomic<bool> is_expert{false};
std::atomic<const char*> last_error{"no error"};
thread_local BehindLibrary::Pose pose;
thread_local std::string name;

constexpr int kOk = 0, kTimeGuard = 1, kFailed = -1;

int Result(Line line) {
  return line == Line::kHere ? kOk : line == Line::kSilent ? kTimeGuard : kFailed;
}

}  // namespace

extern "C" {

void EnamelSetBehindLibrary(BehindLibrary* behind) { device = behind; }

void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = 3;
  *minor = ENAMEL_DOUBLE_MINOR;
  *release = 0;
  *revision = 1;
}
int dhdOpen() {
  last_error = device == nullptr ? "no device found" : device.load()->Open();
  return last_error == nullptr ? 0 : kFailed;
}
int dhdClose(char) {
  device.load()->Close();
  return kOk;
}
const char* dhdErrorGetLastStr() { return last_error; }
const char* dhdGetSystemName(char) {
  name = device.load()->facts().name;
  return name.empty() ? nullptr : name.c_str();
}
int dhdGetSerialNumber(unsigned short* serial, char) {
  *serial = static_cast<unsigned short>(device.load()->facts().serial);
  return kOk;
}
bool dhdHasWrist(char) { return device.load()->facts().wrist; }
bool dhdHasActiveWrist(char) { return device.load()->facts().wrist; }
bool dhdHasGripper(char) { return device.load()->facts().gripper; }
int dhdEmulateButton(unsigned char on, char) {
  device.load()->EmulateButton(on != 0);
  return kOk;
}
int dhdEnableExpertMode() {
  is_expert = true;
  return kOk;
}
int dhdDisableExpertMode() {
  is_expert = false;
  return kOk;
}
#ifndef ENAMEL_DOUBLE_WITHOUT_WATCHDOG
int dhdSetWatchdog(unsigned char units_125us, char) {
  if (!is_expert) return kFailed;
  device.load()->SetWatchdog(units_125us * 125);
  return kOk;
}
#endif
int dhdSetTimeGuard(int, char) { return is_expert ? kOk : kFailed; }
int dhdEnableForce(unsigned char on, char) {
  device.load()->SwitchMotors(on != 0);
  return kOk;
}
int dhdGetStatus(int* status, char) {
  constexpr int kNumbers = 17;
  std::fill_n(status, kNumbers, 0);
  const BehindLibrary::Facts facts = device.load()->facts();
  status[3] = facts.calibrated ? 0 : 1;
  status[5] = facts.motors ? 1 : 0;
  status[8] = status[12] = facts.wrist ? 1 : 0;
  status[14] = facts.off_cause;
  return kOk;
}
int dhdGetPosition(double* x, double* y, double* z, char) {
  const Line line = device.load()->Read(pose);
  *x = pose.position[0];
  *y = pose.position[1];
  *z = pose.position[2];
  return Result(line);
}
int dhdGetOrientationFrame(double matrix[3][3], char) {
  for (size_t i = 0; i < 3; ++i) std::copy(pose.frame[i].begin(), pose.frame[i].end(), matrix[i]);
  return kOk;
}
int dhdGetButton(int, char) { return pose.button ? 1 : 0; }
int dhdSetForce(double x, double y, double z, char) {
  return Result(device.load()->Write({x, y, z}, {}));
}
int dhdSetForceAndTorque(double x, double y, double z, double tx, double ty, double tz, char) {
  return Result(device.load()->Write({x, y, z}, {tx, ty, tz}));
}

}  // extern "C"
