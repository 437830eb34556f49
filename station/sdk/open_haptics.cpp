#include <array>
#include <chrono>
#include <optional>
#include <string>

#include "common/base/triple_buffer.h"
#include "station/devices/force_keeper.h"
#include "station/devices/force_signal.h"
#include "station/devices/limited.h"
#include "station/devices/trouble.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/frames.h"
#include "station/sdk/makers_library.h"

// 3D Systems' devices (Touch, PHANTOM) through OpenHaptics' HDAPI. Functions, units and numbers as published
// in its reference (3.0 and later): mm, N, transforms by columns; x right, y up, z toward the user.
namespace enamel::station::sdk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr MakersLibrary::Names kNames{"3D Systems",
                                      "openhaptics",
                                      {"libHD.so.3.4", "libHD.so"},
                                      kOpenHapticsNodes,
                                      "3D Systems' OpenHaptics and Touch Device Driver for Linux"};

using Handle = unsigned int;
constexpr Handle kNoHandle = 0xFFFFFFFF;
constexpr unsigned int kCurrentButtons = 0x2000, kCurrentTransform = 0x2052, kModelType = 0x2501,
                       kSerialNumber = 0x2504, kCalibrationStyle = 0x2555, kCurrentForce = 0x2700,
                       kForceOutput = 0x4000, kNeedsUpdate = 0x5001, kNeedsHand = 0x5002;
constexpr int kButton1 = 1, kButton2 = 2;
// Errors 0x0200 to 0x02FF: the library has switched the force off, since the motors are warm, or the
// device was pushed or moved beyond what it bears.
constexpr unsigned int kForceErrors = 0x0200, kDeviceErrors = 0x0300, kAlreadyInitiated = 0x0301,
                       kTimerError = 0x0304;
constexpr unsigned int kDone = 0, kContinue = 1;
constexpr unsigned short kPriority = 32'767;  // the scheduler's default

// Frames come every millisecond; the driver waits this long for one.
constexpr int64_t kFrame_us = 2'000;

struct ErrorInfo {
  unsigned int code;
  int internal;
  Handle device;
};

struct Hd {
  Handle (*init)(const char*);
  void (*disable_device)(Handle);
  void (*make_current)(Handle);
  void (*begin_frame)(Handle);
  void (*end_frame)(Handle);
  const char* (*text)(unsigned int);
  void (*doubles)(unsigned int, double*);
  void (*integers)(unsigned int, int*);
  void (*set_doubles)(unsigned int, const double*);
  void (*enable)(unsigned int);
  void (*disable)(unsigned int);
  void (*start_scheduler)();
  void (*stop_scheduler)();
  unsigned long (*schedule)(unsigned int (*)(void*), void*, unsigned short);
  void (*unschedule)(unsigned long);
  ErrorInfo (*error)();
  const char* (*error_text)(unsigned int);
  unsigned int (*check_calibration)();
  void (*update_calibration)(unsigned int);

  // The library stacks its errors. The newest one, or 0; all are taken off.
  unsigned int TakeError() const {
    const unsigned int newest = error().code;
    constexpr int kMaxStacked = 64;
    for (int i = 0; newest != 0 && i < kMaxStacked && error().code != 0; ++i) {
    }
    return newest;
  }
  std::string Text(unsigned int what, const char* otherwise) const {
    const char* found = text(what);
    return found == nullptr ? otherwise : found;
  }
};

Result<Hd> Load(const std::string& file) {
  ENAMEL_ASSIGN_OR_RETURN(MakersLibrary library, MakersLibrary::Load(kNames, file));
  Hd out{};
  library.Find("hdInitDevice", out.init);
  library.Find("hdDisableDevice", out.disable_device);
  library.Find("hdMakeCurrentDevice", out.make_current);
  library.Find("hdBeginFrame", out.begin_frame);
  library.Find("hdEndFrame", out.end_frame);
  library.Find("hdGetString", out.text);
  library.Find("hdGetDoublev", out.doubles);
  library.Find("hdGetIntegerv", out.integers);
  library.Find("hdSetDoublev", out.set_doubles);
  library.Find("hdEnable", out.enable);
  library.Find("hdDisable", out.disable);
  library.Find("hdStartScheduler", out.start_scheduler);
  library.Find("hdStopScheduler", out.stop_scheduler);
  library.Find("hdScheduleAsynchronous", out.schedule);
  library.Find("hdUnschedule", out.unschedule);
  library.Find("hdGetError", out.error);
  library.Find("hdGetErrorString", out.error_text);
  library.Find("hdCheckCalibration", out.check_calibration);
  library.Find("hdUpdateCalibration", out.update_calibration);
  ENAMEL_RETURN_IF_ERROR(library.Check());
  return out;
}

dvec3 ToScene(const double* v) { return {v[0], -v[2], v[1]}; }

// The stylus' frame in the scene. No source gives its axis: here it points along its own -z, as a bur does.
std::optional<Quat> Turned(const std::array<double, 16>& columns) {
  return QuatOfColumns(ToScene(&columns[0]), ToScene(&columns[4]), ToScene(&columns[8]));
}

Result<Handle> Init(const Hd& hd) {
  const Handle device = hd.init(nullptr);
  const unsigned int error = hd.TakeError();
  if (error == 0 && device != kNoHandle) return device;
  const bool taken = error == kAlreadyInitiated || error == kTimerError;
  const char* why = hd.error_text(error);
  return Status(Code::kUnavailable,
                std::string("OpenHaptics opens no device (") + (why == nullptr ? "" : why) + "): " +
                    (taken ? "it is in use by another program: close that program"
                           : "connect it, switch it on, and run Touch_HeadlessSetup once, as this "
                             "user"),
                taken ? trouble::kInUse : trouble::kNotAttached);
}

std::string NameOf(const Hd& hd) { return hd.Text(kModelType, "OpenHaptics device"); }
std::string UnitOf(const Hd& hd) {
  const std::string serial = hd.Text(kSerialNumber, "");
  return serial.empty() ? serial : "openhaptics:" + serial;
}
// As far as nobody has to help.
Status WhyNotUsable(const Hd& hd) {
  if (hd.check_calibration() == kNeedsUpdate) {
    int style = 0;
    hd.integers(kCalibrationStyle, &style);
    hd.update_calibration(static_cast<unsigned int>(style));
  }
  const bool needs_hand = hd.check_calibration() == kNeedsHand;
  hd.TakeError();
  if (!needs_hand) return Status::Ok();
  return Status(Code::kUnavailable, "it is not calibrated: put its stylus into the inkwell",
                trouble::kInkwell);
}

// Only the library's own servo thread may open a frame, every millisecond; it must not be kept waiting. So
// that thread and the station's exchange newest values.
class OpenHaptics final : public PolledBus {
 public:
  OpenHaptics(const Hd& hd, Handle device, double peak_n)
      : hd_(hd), device_(device), peak_n_(peak_n), name_(NameOf(hd)), unit_(UnitOf(hd)) {}
  ~OpenHaptics() override {
    if (scheduled_ != kNotScheduled) {
      // The last force, 0, goes out in the next whole frame.
      for (int i = 0; i < 2; ++i) framed_.Wait(kFrame_us);
      hd_.stop_scheduler();
      hd_.unschedule(scheduled_);
      hd_.make_current(device_);
      hd_.disable(kForceOutput);
    }
    hd_.disable_device(device_);
  }
  std::string Name() const override { return name_; }
  std::string Driver() const override { return kNames.driver; }
  std::string Unit() const override { return unit_; }

  Heard Read(Pose& out) override {
    if (frames_.Read().number == seen_) framed_.Wait(kFrame_us);
    const Frame& newest = frames_.Read();
    if (newest.is_gone) return Heard::kGone;
    if (newest.number == seen_) return Heard::kNothing;
    seen_ = newest.number;
    if (!newest.is_sound) return Heard::kRefused;
    out = newest.pose;
    return Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    forces_.Write({Limited(force_n, peak_n_), Clock::now()});
    return !frames_.Read().is_gone;
  }

  // Switches the motors on and awaits the first pose. Errors: kUnavailable.
  Status Begin() {
    ENAMEL_RETURN_IF_ERROR(UsableUnless(WhyNotUsable(hd_), name_));
    hd_.enable(kForceOutput);
    scheduled_ = hd_.schedule(&Servo, this, kPriority);
    hd_.start_scheduler();
    if (const unsigned int error = hd_.TakeError(); error != 0) {
      const char* why = hd_.error_text(error);
      return Status(Code::kUnavailable,
                    name_ + ": its servo loop does not start (" + (why == nullptr ? "" : why) +
                        "): close other programs that use it",
                    trouble::kInUse);
    }
    return AwaitFirstPose(*this);
  }

 private:
  static constexpr unsigned long kNotScheduled = ~0UL;
  struct Frame {
    Pose pose;
    uint64_t number = 0;
    bool is_gone = false;
    bool is_sound = false;  // its numbers can be a pose's
  };
  struct Force {
    dvec3 newtons{0};
    Clock::time_point since{};
  };

  static unsigned int Servo(void* self) { return static_cast<OpenHaptics*>(self)->ServoFrame(); }
  unsigned int ServoFrame() noexcept {
    std::array<double, 16> columns{};
    int buttons = 0;
    hd_.make_current(device_);
    hd_.begin_frame(device_);
    hd_.doubles(kCurrentTransform, columns.data());
    hd_.integers(kCurrentButtons, &buttons);
    // The library has no watchdog that anybody published: a force that the station's thread no longer
    // renews ends here.
    const Force newest = forces_.Read();
    const bool is_old =
        Clock::now() - newest.since > std::chrono::microseconds(ForceKeeper::kGone_us);
    const dvec3 f = is_old ? dvec3(0) : newest.newtons;
    const double force[3] = {f.x, f.z, -f.y};
    hd_.set_doubles(kCurrentForce, force);
    hd_.end_frame(device_);
    const unsigned int error = hd_.TakeError();
    frame_.pose.driven = error < kForceErrors || error >= kDeviceErrors;
    frame_.is_gone = error != 0 && frame_.pose.driven;
    if (!frame_.is_gone) {
      frame_.pose.tip_m = ToScene(&columns[12]) * 1e-3;
      const auto turn = Turned(columns);
      frame_.pose.orientation = turn.value_or(Quat());
      frame_.is_sound = turn && CanBe(frame_.pose);
      frame_.pose.pedal = (buttons & kButton1) != 0;
      frame_.pose.second = (buttons & kButton2) != 0;
    }
    ++frame_.number;
    frames_.Write(frame_);
    framed_.Post();
    return frame_.is_gone ? kDone : kContinue;
  }

  const Hd hd_;
  const Handle device_;
  const double peak_n_;
  const std::string name_, unit_;
  TripleBuffer<Frame> frames_;
  TripleBuffer<Force> forces_;
  ForceSignal framed_;
  Frame frame_;  // owned by the servo thread
  // Owned by the station's.
  uint64_t seen_ = 0;
  unsigned long scheduled_ = kNotScheduled;
};

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenOpenHaptics(const BusChoice& choice) {
  ENAMEL_ASSIGN_OR_RETURN(const Hd hd, Load(choice.address));
  ENAMEL_ASSIGN_OR_RETURN(const Handle device, Init(hd));
  auto bus = std::make_unique<OpenHaptics>(hd, device, choice.peak_n);
  ENAMEL_RETURN_IF_ERROR(bus->Begin());
  return std::unique_ptr<PolledBus>(std::move(bus));
}

Status LoadOpenHaptics() { return Load({}).status(); }

std::vector<SdkDevice> FindOpenHaptics() {
  const auto hd = Load({});
  if (!hd.ok()) return WithoutLibrary(kNames, hd.status());
  const auto device = Init(*hd);
  if (!device.ok()) return NotOpened(kNames, device.status());
  const std::string name = NameOf(*hd);
  SdkDevice found{"", name, ProfileNameOf(name), "", UnitOf(*hd), WhyNotUsable(*hd)};
  hd->disable_device(*device);
  return {std::move(found)};
}

}  // namespace enamel::station::sdk
