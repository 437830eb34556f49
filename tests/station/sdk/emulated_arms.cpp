#include "tests/station/sdk/emulated_arms.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include "common/base/check.h"
#include "tests/station/hid/hid_double.h"

namespace enamel::station::testing_support {

namespace {

// Inside the workspace, by the arm's dimensions.
constexpr std::array<int, 6> kWoodenStart = {0, -1333, 3453, 0, 0, 0};
constexpr std::array<int, 6> kPolhemStart = {0, -1389, -1667, 0, 0, 0};

constexpr double kLoweredStep_m = 40e-6;

int Word(ByteView bytes, size_t i) {
  return static_cast<int16_t>(bytes[1 + 2 * i] | bytes[2 + 2 * i] << 8);
}

std::string OwnFile() {
  std::string path = std::filesystem::temp_directory_path() / "enamel-arm-XXXXXX";
  ENAMEL_CHECK(Fd(::mkstemp(path.data())).get() >= 0);
  return path;
}

}  // namespace

EmulatedHidArm::EmulatedHidArm(bool polhem)
    : polhem_(polhem), path_(OwnFile()), counters_(polhem ? kPolhemStart : kWoodenStart) {
  Plug();
  thread_ = std::thread([this] { Run(); });
}

void EmulatedHidArm::Plug() {
  ScriptedHid device;
  device.path = path_;
  device.vendor = 0x1234;
  device.product = 0x0006;
  device.answer = [this](ByteView report) {
    std::lock_guard lock(inbox_mutex_);
    inbox_.emplace_back(report.begin(), report.end());
    written_.notify_one();
    return Bytes{};
  };
  HidBus::Get().Plug(device);
}

EmulatedHidArm::~EmulatedHidArm() {
  HidBus::Get().Unplug(path_);
  {
    std::lock_guard lock(inbox_mutex_);
    stop_ = true;
    written_.notify_one();
  }
  thread_.join();
  std::filesystem::remove(path_);
}

void EmulatedHidArm::Run() {
  std::unique_lock lock(inbox_mutex_);
  while (true) {
    written_.wait(lock, [&] { return stop_ || !inbox_.empty(); });
    if (stop_) return;
    const Bytes report = std::move(inbox_.front());
    inbox_.pop_front();
    lock.unlock();
    if (const auto wait = Wait(); wait.count() > 0) std::this_thread::sleep_for(wait);
    if (const Bytes answer = Answer(report); !answer.empty()) HidBus::Get().Send(path_, answer);
    lock.lock();
  }
}

dvec3 TipOf(const ArmDrawing& d, const std::array<int, 6>& n) {
  const auto angle = [&](size_t i) { return -n[i] * std::numbers::pi / 1000 / d.gear[i]; };
  const double turn = angle(0), rise = angle(1), fore = d.zero_c + angle(2);
  // Body b leans by `rise` from the vertical, body c hangs by `fore`; both turn about the base.
  const double out = d.b * std::sin(rise) + d.c * std::sin(fore);
  const dvec3 arm{out * std::cos(turn) - d.origin.x, out * std::sin(turn) - d.origin.y,
                  d.a + d.b * std::cos(rise) - d.c * std::cos(fore) - d.origin.z};
  return {arm.y, -arm.x, arm.z};  // x toward the user, y right: scene
}

void EmulatedHidArm::Unplug() { HidBus::Get().Unplug(path_); }

void EmulatedHidArm::Set(const std::array<int, 6>& counters) {
  std::lock_guard lock(mutex_);
  counters_ = counters;
}

std::array<int, 6> EmulatedHidArm::counters() const {
  std::lock_guard lock(mutex_);
  return counters_;
}

void EmulatedHidArm::Lower(int steps) {
  // Newton's method for the counters of bodies b and c, from the start, which is near.
  const ArmDrawing& d = kArmDrawings[polhem_ ? 1 : 0];
  auto counters = polhem_ ? kPolhemStart : kWoodenStart;
  const dvec3 start = TipOf(d, counters);
  constexpr double kAhead = 50;
  for (int i = 0; i < 8; ++i) {
    auto b = counters, c = counters;
    b[1] += static_cast<int>(kAhead);
    c[2] += static_cast<int>(kAhead);
    const dvec3 at = TipOf(d, counters), by_b = (TipOf(d, b) - at) / kAhead,
                by_c = (TipOf(d, c) - at) / kAhead;
    const double y_m = start.y - at.y, z_m = start.z - steps * kLoweredStep_m - at.z;
    const double det = by_b.y * by_c.z - by_c.y * by_b.z;
    counters[1] += static_cast<int>(std::lround((y_m * by_c.z - by_c.y * z_m) / det));
    counters[2] += static_cast<int>(std::lround((by_b.y * z_m - y_m * by_b.z) / det));
  }
  Set(counters);
}

void EmulatedHidArm::PressCalibration() {
  std::lock_guard lock(mutex_);
  counters_ = {7, -8, 9, 10, 11, 12};
  info_ = 1;
}

Bytes EmulatedHidArm::Answer(ByteView report) {
  std::lock_guard lock(mutex_);
  ++requests_;
  // What does not have the firmware's length it does not read, and so does not answer.
  if (report.size() != 1 + answer_bytes() || report[0] != 0) return {};
  if (polhem_ && Word(report, 3) == 1) {
    homed_ = Word(report, 4) == 0 && Word(report, 5) == 0 && Word(report, 6) == -5000 &&
             Word(report, 0) == 0 && Word(report, 1) == 0 && Word(report, 2) == 0;
    counters_ = kPolhemStart;
    info_ = 0;
  } else {
    for (size_t i = 0; i < 3; ++i) told_[i] = Word(report, i);
  }
  Bytes answer(answer_bytes());
  for (size_t i = 0; i < answer.size() / 2; ++i) {
    const auto word = static_cast<uint16_t>(i < 6 && (polhem_ || i < 3) ? counters_[i] : info_);
    answer[2 * i] = static_cast<uint8_t>(word & 0xFF);
    answer[2 * i + 1] = static_cast<uint8_t>(word >> 8);
  }
  return Through(std::move(answer));
}

EmulatedSerialArm::EmulatedSerialArm() { Plug(); }

void EmulatedSerialArm::Plug() {
  master_ = std::make_unique<Fd>(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  ENAMEL_CHECK(master_->get() >= 0 && ::grantpt(master_->get()) == 0 &&
               ::unlockpt(master_->get()) == 0);
  const std::string path = ::ptsname(master_->get());
  std::filesystem::create_symlink(path, link());
  // Open as long as the device is plugged in, so that a driver that closes it hangs nothing up.
  slave_ = std::make_unique<Fd>(::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  stop_ = false;
  thread_ = std::thread([this] { Run(); });
}

EmulatedSerialArm::~EmulatedSerialArm() { Unplug(); }

void EmulatedSerialArm::Unplug() {
  // First: the terminal's name may be another program's at once.
  std::filesystem::remove(link());
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  slave_.reset();
  master_.reset();
}

void EmulatedSerialArm::Set(const std::array<double, 3>& tip_mm,
                            const std::array<double, 4>& joints_rad) {
  std::lock_guard lock(mutex_);
  tip_mm_ = tip_mm;
  joints_rad_ = joints_rad;
}

void EmulatedSerialArm::Lower(int steps) { Set({0, 0, -0.04 * steps}); }

void EmulatedSerialArm::PressCalibration() {
  std::lock_guard lock(mutex_);
  tip_mm_ = {123, 45, 200};
  info_ = 1;
}

void EmulatedSerialArm::Run() {
  std::string text;
  while (!stop_) {
    pollfd ready{master_->get(), POLLIN, 0};
    if (::poll(&ready, 1, 1) <= 0) continue;
    char piece[256];
    const ssize_t got = ::read(master_->get(), piece, sizeof piece);
    if (got <= 0) continue;
    text.append(piece, static_cast<size_t>(got));
    for (size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1)) {
      Take(text.substr(0, end));
    }
  }
}

void EmulatedSerialArm::Take(const std::string& line) {
  if (const auto wait = Wait(); wait.count() > 0) std::this_thread::sleep_for(wait);
  std::lock_guard lock(mutex_);
  ++requests_;
  int w[7] = {};
  if (std::sscanf(line.c_str(), "%d %d %d %d %d %d %d", w, w + 1, w + 2, w + 3, w + 4, w + 5,
                  w + 6) != 7) {
    return;
  }
  if (w[3] == 1) {
    homed_ =
        w[0] == 0 && w[1] == 30 && w[2] == 0 && w[4] == 8298 && w[5] == -10771 && w[6] == 19756;
    tip_mm_ = {};
    info_ = 0;
  } else if (w[3] == 2) {
    told_ = {w[0], w[1], w[2]};
  }
  char answer[80];
  int n = std::snprintf(answer, sizeof answer, "%8.3f %8.3f %8.3f %7.4f %7.4f %7.4f %7.4f %d",
                        tip_mm_[0], tip_mm_[1], tip_mm_[2], joints_rad_[0], joints_rad_[1],
                        joints_rad_[2], joints_rad_[3], info_);
  Bytes bytes(answer, answer + n);
  bytes.resize(64, ' ');
  bytes.back() = '\n';
  if (lose_) bytes.erase(bytes.begin() + 3);
  Send(Through(std::move(bytes)));
}

void EmulatedSerialArm::Send(const Bytes& bytes) {
  const size_t first = pieces_ ? bytes.size() / 3 : 0;
  if (pieces_) ENAMEL_CHECK(::write(master_->get(), "\n", 1) == 1);
  if (first > 0) ENAMEL_CHECK(::write(master_->get(), bytes.data(), first) >= 0);
  if (bytes.size() > first) {
    ENAMEL_CHECK(::write(master_->get(), bytes.data() + first, bytes.size() - first) >= 0);
  }
}

}  // namespace enamel::station::testing_support
