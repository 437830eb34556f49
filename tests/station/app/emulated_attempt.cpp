// Makes an attempt with an emulated device in the hand of a program: emulated_attempt DEVICE DATA LOGIN EXERCISE OUT.json
// The station's own `run` from sign-in to the last acknowledgement, at the clock's pace; ENAMEL_PASSWORD as there. Down
// to the tooth with the bur off, into it with the pedal down, up again, end.
#include <atomic>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/program/log.h"
#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "station/app/attempt.h"
#include "station/hid/space_mouse.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/doubled_arm.h"
#include "tests/station/sdk/emulated_arms.h"
#include "tests/station/sdk/emulated_falcon.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

using std::chrono::milliseconds;
using testing_support::HidBus;
using testing_support::ScriptedHid;

constexpr double kStep_m = 40e-6;  // of EmulatedArm::Lower
// Device centres are 8 mm above the work: 5 mm quickly through the air, 7 mm more at 10 mm/s.
constexpr int kFreeSteps = 120, kSteps = 300, kStrokes = 3;
constexpr milliseconds kInAir{2}, kInTooth{4}, kUntilFirstTick{1500};

// A hand that goes straight down, and what it holds.
class Hand {
 public:
  virtual ~Hand() = default;
  virtual std::string choice() const = 0;
  virtual std::string profile() const = 0;
  virtual void Lower(int steps) = 0;
};

class Arm final : public Hand {
 public:
  explicit Arm(std::unique_ptr<lab::EmulatedArm> arm) : arm_(std::move(arm)) {}
  std::string choice() const override { return arm_->choice(); }
  std::string profile() const override { return arm_->profile(); }
  void Lower(int steps) override { arm_->Lower(steps); }

 private:
  const std::unique_ptr<lab::EmulatedArm> arm_;
};

// On the HID port's double, reporting about a thousand times a second.
class Reporting : public Hand {
 public:
  ~Reporting() override { Stop(); }
  void Lower(int steps) override { steps_ = steps; }

 protected:
  Reporting(std::string path, uint16_t vendor, uint16_t product, uint16_t page, uint16_t usage) {
    std::ofstream(path) << "";  // who may read and write the file may use the device
    device_.path = std::move(path);
    device_.vendor = vendor;
    device_.product = product;
    device_.usage_page = page;
    device_.usage = usage;
  }
  void Start() {
    HidBus::Get().Plug(device_);
    thread_ = std::thread([this] {
      for (; !stop_; std::this_thread::sleep_for(milliseconds(1))) Report(device_.path, steps_);
    });
  }
  void Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  virtual void Report(const std::string& path, int steps) = 0;
  ScriptedHid device_;

 private:
  std::atomic<int> steps_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

class Board final : public Reporting {
 public:
  explicit Board(const std::string& path)
      : Reporting(path, 0x1209, 0x0001, hid::kBoardUsagePage, hid::kBoardUsage) {
    const scene::DeviceProfile profile = *scene::FindProfile(this->profile());
    cell_m_ = static_cast<double>(scene::CountNm(profile)) * 1e-9;
    hid::FeatureReport feature;
    feature.resolution_nm.fill(static_cast<uint32_t>(scene::CountNm(profile)));
    feature.peak_force_mn.fill(static_cast<uint32_t>(profile.peak_force_mn.value));
    feature.rate_hz = 1000;
    feature.max_watchdog_ms = 100;
    feature.name = "Bench arm";
    feature.profile = this->profile();
    const auto bytes = hid::EncodeFeature(feature);
    device_.feature.assign(bytes.begin(), bytes.end());
    Start();
  }
  ~Board() override { Stop(); }
  std::string choice() const override { return "hid"; }
  std::string profile() const override { return "phantom_desktop"; }

 private:
  void Report(const std::string& path, int steps) override {
    ++report_.sequence;
    report_.time_us += 1000;
    report_.counts[2] = static_cast<int32_t>(-steps * kStep_m / cell_m_);
    HidBus::Get().Send(path, hid::EncodeInput(report_));
  }
  double cell_m_ = 0;
  hid::InputReport report_;
};

// Pushed until it has gone as far; its own button is not used.
class Mouse final : public Reporting {
 public:
  explicit Mouse(const std::string& path)
      : Reporting(path, 0x256f, 0xc62e, hid::kMultiAxisPage, hid::kMultiAxisUsage) {
    Start();
  }
  ~Mouse() override { Stop(); }
  std::string choice() const override { return "spacemouse"; }
  std::string profile() const override { return "pointer"; }

 private:
  void Report(const std::string& path, int steps) override {
    // At full deflection 20 mm/s: in these reports of a millisecond half a step.
    const double wanted = 2.0 * steps;
    const int push = wanted > gone_ ? 350 : wanted < gone_ - 1 ? -350 : 0;
    gone_ += push > 0 ? 1 : push < 0 ? -1 : 0;
    const auto low = static_cast<uint8_t>(push & 0xff), high = static_cast<uint8_t>(push >> 8);
    const uint8_t report[] = {1, 0, 0, 0, 0, low, high, 0, 0, 0, 0, 0, 0};
    HidBus::Get().Send(path, report);
  }
  double gone_ = 0;
};

std::unique_ptr<Hand> HandWith(const std::string& device, const test::TempFolder& folder) {
  using namespace testing_support;
  if (device == "hid") return std::make_unique<Board>((folder.path() / "board").string());
  if (device == "spacemouse") return std::make_unique<Mouse>((folder.path() / "mouse").string());
  std::unique_ptr<lab::EmulatedArm> arm;
  if (device == "inverse3") arm = std::make_unique<lab::EmulatedInverse3>();
  if (device == "polhem_serial") arm = std::make_unique<EmulatedSerialArm>();
  if (device == "falcon") arm = std::make_unique<EmulatedFalcon>();
  if (device == "dhd" || device == "openhaptics") arm = std::make_unique<DoubledArm>(device);
  if (device == "polhem" || device == "woodenhaptics")
    arm = std::make_unique<EmulatedHidArm>(device == "polhem");
  return arm ? std::make_unique<Arm>(std::move(arm)) : nullptr;
}

class Pedal {
 public:
  explicit Pedal(const test::TempFolder& folder) : path_((folder.path() / "pedal").string()) {
    std::ofstream(path_) << "";
    ScriptedHid pedal;
    pedal.path = path_;
    pedal.vendor = 0x05f3;
    pedal.product = 0x00ff;
    HidBus::Get().Plug(pedal);
  }
  void Set(bool down) {
    const uint8_t report[] = {static_cast<uint8_t>(down ? 1 : 0), 0};
    HidBus::Get().Send(path_, report);
  }

 private:
  const std::string path_;
};

// What RunAttempt asks and is told: asked whether to finish, it runs.
struct Course {
  std::atomic<bool> runs{false}, done{false}, over{false};
  bool Finish() {
    runs = true;
    return done;
  }
};

// Several strokes at one place: on a busy computer a fault ends the force for a stroke.
void Cut(Hand& hand, Pedal& pedal, Course& course) {
  auto go = [&](int from, int to, milliseconds each) {
    for (int at = from; at != to; at += to > from ? 1 : -1) {
      hand.Lower(at);
      std::this_thread::sleep_for(each);
    }
  };
  while (!course.runs && !course.over) std::this_thread::sleep_for(milliseconds(20));
  if (course.over) return;
  std::this_thread::sleep_for(kUntilFirstTick);
  for (int stroke = 0; stroke < kStrokes; ++stroke) {
    pedal.Set(true);
    go(0, kFreeSteps, kInAir);
    go(kFreeSteps, kSteps, kInTooth);
    go(kSteps, 0, kInAir);
    pedal.Set(false);
    std::this_thread::sleep_for(milliseconds(200));
  }
  course.done = true;
}

int Main(const std::string& device, RunOptions options) {
  test::TempFolder folder;
  Pedal pedal(folder);
  const std::unique_ptr<Hand> hand = HandWith(device, folder);
  if (hand == nullptr) {
    std::fprintf(stderr, "no emulated device '%s'\n", device.c_str());
    return 2;
  }
  options.device.device = hand->choice();
  options.device.pedal = "05f3:00ff";
  options.profile = hand->profile();
  Course course;
  options.finish = [&course] { return course.Finish(); };
  std::thread cutting([&] { Cut(*hand, pedal, course); });
  const auto result = RunAttempt(options);
  course.over = true;
  cutting.join();
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().message().c_str());
    return 1;
  }
  return result->uploaded ? 0 : 3;
}

}  // namespace
}  // namespace enamel::station

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "emulated_attempt DEVICE DATA LOGIN EXERCISE OUT.json\n");
    return 2;
  }
  enamel::station::RunOptions options;
  options.workplace.data = argv[2];
  options.login = argv[3];
  options.exercise = argv[4];
  options.json = argv[5];
  options.quiet = true;
  const char* password = std::getenv("ENAMEL_PASSWORD");
  options.password = password != nullptr ? password : "";
  return enamel::station::Main(argv[1], options);
}
