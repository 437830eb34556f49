#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>

#include "station/devices/force_keeper.h"
#include "station/devices/limited.h"
#include "station/devices/trouble.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/frames.h"
#include "station/sdk/makers_library.h"

// Force Dimension's devices through the maker's library. Functions, units and numbers as published for
// SDK 3.7 (dhdc.h) and 3.14 (forcedimension_core's reference): m, N, N m, row-major frames.
namespace enamel::station::sdk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr MakersLibrary::Names kNames{"Force Dimension",
                                      "dhd",
                                      {"libdhd.so.3", "libdhd.so"},
                                      kForceDimensionNodes,
                                      "Force Dimension's SDK for Linux, so that ldconfig finds it"};
constexpr const char* kOldest = "3.3.2";  // the first with dhdSetWatchdog
constexpr std::array kOldestParts = {3, 3, 2};

// Results, and places in dhdGetStatus' array.
constexpr int kTimeGuard = 1;  // nothing newer than at the last call
constexpr unsigned char kOff = 0, kOn = 1;
constexpr size_t kStatusReset = 3, kStatusForce = 5, kStatusWristDetected = 8,
                 kStatusWristInit = 12, kStatusOffCause = 14;
// Causes after which the device is driven again by itself: it was too fast, or heard no force. Somebody
// who pressed its button, or let go of its switch, switches it on again there.
constexpr int kOffVelocity = 2, kOffWatchdog = 3;
// Releases from 3.14 on write 17 numbers, and later ones may write more.
constexpr size_t kMaxStatus = 64;

// The firmware switches the motors off when it hears no force for so long. In its unit, which is 125 us.
constexpr unsigned char kWatchdog = ForceKeeper::kGone_us / 125;
// The maker does not say whether dhdGetStatus takes an exchange on the bus. The driver calls it seldom.
constexpr std::chrono::milliseconds kStatusEvery{10};

struct Dhd {
  void (*version)(int*, int*, int*, int*);
  int (*open)();
  int (*close)(char);
  const char* (*error)();
  const char* (*name)(char);
  int (*serial)(unsigned short*, char);
  bool (*has_wrist)(char);
  bool (*has_active_wrist)(char);
  bool (*has_gripper)(char);
  int (*emulate_button)(unsigned char, char);
  int (*enable_expert)();
  int (*disable_expert)();
  int (*set_watchdog)(unsigned char, char);
  int (*set_time_guard)(int, char);
  int (*enable_force)(unsigned char, char);
  int (*status)(int*, char);
  int (*position)(double*, double*, double*, char);
  int (*orientation)(double (*)[3], char);
  int (*button)(int, char);
  int (*set_force)(double, double, double, char);
  int (*set_force_and_torque)(double, double, double, double, double, double, char);
};

Result<Dhd> Load(const std::string& file) {
  ENAMEL_ASSIGN_OR_RETURN(MakersLibrary library, MakersLibrary::Load(kNames, file));
  Dhd out{};
  library.Find("dhdGetSDKVersion", out.version);
  if (out.version != nullptr) {
    std::array<int, 4> at{};
    out.version(&at[0], &at[1], &at[2], &at[3]);
    if (std::lexicographical_compare(at.begin(), at.end(), kOldestParts.begin(),
                                     kOldestParts.end())) {
      return library.TooOld(
          std::to_string(at[0]) + "." + std::to_string(at[1]) + "." + std::to_string(at[2]),
          kOldest);
    }
  }
  library.Find("dhdOpen", out.open);
  library.Find("dhdClose", out.close);
  library.Find("dhdErrorGetLastStr", out.error);
  library.Find("dhdGetSystemName", out.name);
  library.Find("dhdGetSerialNumber", out.serial);
  library.Find("dhdHasWrist", out.has_wrist);
  library.Find("dhdHasActiveWrist", out.has_active_wrist);
  library.Find("dhdHasGripper", out.has_gripper);
  library.Find("dhdEmulateButton", out.emulate_button);
  library.Find("dhdEnableExpertMode", out.enable_expert);
  library.Find("dhdDisableExpertMode", out.disable_expert);
  library.Find("dhdSetWatchdog", out.set_watchdog);
  library.Find("dhdSetTimeGuard", out.set_time_guard);
  library.Find("dhdEnableForce", out.enable_force);
  library.Find("dhdGetStatus", out.status);
  library.Find("dhdGetPosition", out.position);
  library.Find("dhdGetOrientationFrame", out.orientation);
  library.Find("dhdGetButton", out.button);
  library.Find("dhdSetForce", out.set_force);
  library.Find("dhdSetForceAndTorque", out.set_force_and_torque);
  ENAMEL_RETURN_IF_ERROR(library.Check());
  return out;
}

dvec3 ToScene(double x, double y, double z) { return FromUserward({x, y, z}); }

// The handle's frame in the scene: ToScene turns both.
std::optional<Quat> ToScene(const double (&m)[3][3]) {
  // ToScene of the frame's image of each scene axis.
  return QuatOfColumns(ToScene(m[0][1], m[1][1], m[2][1]), -ToScene(m[0][0], m[1][0], m[2][0]),
                       ToScene(m[0][2], m[1][2], m[2][2]));
}

Status OpensNone(const Dhd& dhd) {
  return Status(Code::kUnavailable,
                std::string("no Force Dimension device (") + dhd.error() +
                    "): connect it and switch it on, and close other programs that use it",
                trouble::kNotAttached);
}

std::string NameOf(const Dhd& dhd, char id) {
  const char* name = dhd.name(id);
  return name == nullptr ? "Force Dimension device" : name;
}

std::string UnitOf(const Dhd& dhd, char id) {
  unsigned short serial = 0;
  return dhd.serial(&serial, id) < 0 || serial == 0 ? "" : "dhd:" + std::to_string(serial);
}

// Why the device cannot be used now, and what to do; empty: it can.
Status WhyNotUsable(const Dhd& dhd, char id) {
  std::array<int, kMaxStatus> status{};
  if (dhd.status(status.data(), id) < 0) {
    return Status(Code::kUnavailable, "it does not report its status: plug it in again",
                  trouble::kSilent);
  }
  if (status[kStatusReset] != 0 ||
      (status[kStatusWristDetected] != 0 && status[kStatusWristInit] == 0)) {
    return Status(Code::kUnavailable,
                  "it is not calibrated: put its handle into the calibration pit, and turn the "
                  "handle through its whole range where it turns, until its light no longer blinks",
                  trouble::kPit);
  }
  return Status::Ok();
}

class ForceDimension final : public PolledBus {
 public:
  ForceDimension(const Dhd& dhd, char id, double peak_n)
      : dhd_(dhd),
        id_(id),
        peak_n_(peak_n),
        name_(NameOf(dhd, id)),
        unit_(UnitOf(dhd, id)),
        turns_(dhd.has_wrist(id)),
        twists_(dhd.has_active_wrist(id)) {}
  ~ForceDimension() override {
    // Before closing: afterwards nothing feeds the motors.
    dhd_.enable_force(kOff, id_);
    dhd_.close(id_);
  }
  std::string Name() const override { return name_; }
  std::string Driver() const override { return kNames.driver; }
  std::string Unit() const override { return unit_; }

  Heard Read(Pose& out) override {
    double x = 0, y = 0, z = 0;
    const int got = dhd_.position(&x, &y, &z, id_);
    if (got < 0) return Heard::kGone;
    if (got == kTimeGuard) return Heard::kNothing;
    out.tip_m = ToScene(x, y, z);
    if (turns_) {
      double frame[3][3] = {};
      if (dhd_.orientation(frame, id_) < 0) return Heard::kGone;
      const auto turn = ToScene(frame);
      if (!turn) return Heard::kRefused;
      out.orientation = *turn;
    }
    if (!CanBe(out)) return Heard::kRefused;
    out.pedal = dhd_.button(0, id_) == kOn;
    if (Clock::now() >= status_due_) WatchMotors();
    out.driven = driven_;
    return Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    const dvec3 f = Taken(force_n);
    return dhd_.set_force(f.x, f.y, f.z, id_) >= 0;  // positive: what the motors have is less
  }
  bool SendWithTorque(const dvec3& force_n, const dvec3& torque_n_m) override {
    if (!twists_) return Send(force_n);
    const dvec3 f = Taken(force_n), t = ToUserward(torque_n_m);
    return dhd_.set_force_and_torque(f.x, f.y, f.z, t.x, t.y, t.z, id_) >= 0;
  }

  // Switches the motors on and awaits the first pose. Errors: kUnavailable.
  Status Begin() {
    ENAMEL_RETURN_IF_ERROR(UsableUnless(WhyNotUsable(dhd_, id_), name_));
    // A force that the loop no longer renews has fallen to 0 by then (ForceKeeper), so the firmware's clock
    // ends only what this thread can no longer end. No time guard: it would return at once, and this
    // thread would spin.
    dhd_.enable_expert();
    dhd_.set_watchdog(kWatchdog, id_);
    dhd_.set_time_guard(0, id_);
    dhd_.disable_expert();
    if (dhd_.has_gripper(id_)) dhd_.emulate_button(kOn, id_);  // closed: pressed
    dhd_.enable_force(kOn, id_);
    return AwaitFirstPose(*this);
  }

 private:
  dvec3 Taken(const dvec3& force_n) {
    pushes_ = force_n != dvec3(0);
    return ToUserward(Limited(force_n, peak_n_));
  }
  // While the loop pushes, the motors stay off: it sees that they are, as a fault.
  void WatchMotors() {
    status_due_ = Clock::now() + kStatusEvery;
    std::array<int, kMaxStatus> status{};
    if (dhd_.status(status.data(), id_) < 0) return;  // the next call for a pose finds it gone
    driven_ = status[kStatusForce] != 0;
    const int cause = status[kStatusOffCause];
    if (!driven_ && !pushes_ && (cause == kOffVelocity || cause == kOffWatchdog)) {
      dhd_.enable_force(kOn, id_);
    }
  }

  const Dhd dhd_;
  const char id_;
  const double peak_n_;
  const std::string name_, unit_;
  const bool turns_, twists_;  // senses rotation, drives it
  bool driven_ = true, pushes_ = false;
  Clock::time_point status_due_{};
};

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenForceDimension(const BusChoice& choice) {
  ENAMEL_ASSIGN_OR_RETURN(const Dhd dhd, Load(choice.address));
  const int id = dhd.open();
  if (id < 0) return OpensNone(dhd);
  auto bus = std::make_unique<ForceDimension>(dhd, static_cast<char>(id), choice.peak_n);
  ENAMEL_RETURN_IF_ERROR(bus->Begin());
  return std::unique_ptr<PolledBus>(std::move(bus));
}

Status LoadForceDimension() { return Load({}).status(); }

std::vector<SdkDevice> FindForceDimension() {
  const auto dhd = Load({});
  if (!dhd.ok()) return WithoutLibrary(kNames, dhd.status());
  const int opened = dhd->open();
  if (opened < 0) return NotOpened(kNames, OpensNone(*dhd));
  const auto id = static_cast<char>(opened);
  const std::string name = NameOf(*dhd, id);
  SdkDevice found{"", name, ProfileNameOf(name), "", UnitOf(*dhd, id), WhyNotUsable(*dhd, id)};
  dhd->close(id);
  return {std::move(found)};
}

}  // namespace enamel::station::sdk
