#include "tests/station/sdk/emulated_falcon.h"

#include <cmath>
#include <fstream>
#include <numbers>

#include "common/base/check.h"
#include "tests/station/sdk/usb_double.h"

namespace enamel::station::testing_support {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;
// As libnifalcon's getTheta: degrees a count, degrees at 0.
constexpr double kDegreesPerCount = 360 * 0.01425 / (1280 * 0.110), kDegreesAtZero = 35;
constexpr double kMiddle_m = 0.125;
constexpr uint8_t kReset = 0, kModem = 1, kBaud = 3, kLatency = 9;
constexpr int kBaud9600 = 0x4138, kBaudUpload = 0x15, kBaudFrames = 0x2;

}  // namespace

dvec3 FalconAnglesAt(const dvec3& tip_m) {
  constexpr double a = 0.060, b = 0.1025, c = 0.01443, d = 0.01125, e = d, f = -0.025, r = 0.040,
                   s = -0.02309;
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    const double phi = (105 - 120 * i) * kRadPerDegree;
    const double u = std::cos(phi) * tip_m.x + std::sin(phi) * tip_m.y - r,
                 v = std::cos(phi) * tip_m.y - std::sin(phi) * tip_m.x - s, w = tip_m.z;
    const double theta3 = std::acos((v + f) / b), shin = d + e + b * std::sin(theta3);
    const double l0 = w * w + (u + c - a) * (u + c - a) - shin * shin, l1 = -4 * a * w,
                 l2 = w * w + (u + c + a) * (u + c + a) - shin * shin;
    out[i] = 2 * std::atan((-l1 - std::sqrt(l1 * l1 - 4 * l0 * l2)) / (2 * l2));
  }
  return out;
}

EmulatedFalcon::EmulatedFalcon() {
  for (int i = 0; i < 300; ++i) firmware_.push_back(static_cast<uint8_t>(7 * i + i / 251));
  std::ofstream(firmware_file(), std::ios::binary)
      .write(reinterpret_cast<const char*>(firmware_.data()),
             static_cast<std::streamsize>(firmware_.size()));
  Set({0, 0, kMiddle_m});
  Plug();
  thread_ = std::thread([this] { Run(); });
}

void EmulatedFalcon::PlugAt(const char* place) {
  place_ = place;
  ScriptedUsb device;
  device.vendor = 0x0403;
  device.product = 0xcb48;
  device.control = [this](uint8_t request, uint16_t value) {
    Say({Said::kRequest, request, value, {}});
    return request == kReset && value == 1;
  };
  device.written = [this](ByteView bytes) {
    Say({Said::kBytes, 0, 0, Bytes(bytes.begin(), bytes.end())});
  };
  UsbBus::Get().Plug(place, device);
}

EmulatedFalcon::~EmulatedFalcon() {
  Unplug();
  {
    std::lock_guard lock(inbox_mutex_);
    stop_ = true;
    came_.notify_one();
  }
  thread_.join();
}

void EmulatedFalcon::Unplug() { UsbBus::Get().Unplug(place_.load()); }

bool EmulatedFalcon::PlugOther() {
  PlugAt("1-3");
  return true;
}

void EmulatedFalcon::SwitchOff() {
  is_powered_ = false;
  Say({Said::kPower, 0, 0, {}});
  while (runs_) std::this_thread::yield();
}

void EmulatedFalcon::SwitchOn() {
  homes_ = true;
  is_powered_ = true;
}

void EmulatedFalcon::Set(const dvec3& tip_m) {
  const dvec3 angles = FalconAnglesAt(tip_m);
  std::array<int, 3> counts;
  for (int i = 0; i < 3; ++i) {
    counts[static_cast<size_t>(i)] = static_cast<int>(
        std::lround((angles[i] / kRadPerDegree - kDegreesAtZero) / kDegreesPerCount));
  }
  SetCounts(counts);
}

void EmulatedFalcon::SetCounts(const std::array<int, 3>& counts) {
  std::lock_guard lock(mutex_);
  counts_ = counts;
}

std::array<int, 3> EmulatedFalcon::counts() const {
  std::lock_guard lock(mutex_);
  return counts_;
}

void EmulatedFalcon::Lower(int steps) { Set({0, -40e-6 * steps, kMiddle_m}); }

void EmulatedFalcon::Say(Said said) {
  std::lock_guard lock(inbox_mutex_);
  inbox_.push_back(std::move(said));
  came_.notify_one();
}

void EmulatedFalcon::Run() {
  std::unique_lock lock(inbox_mutex_);
  while (true) {
    const bool idle = !came_.wait_for(lock, std::chrono::milliseconds(latency_ms_),
                                      [&] { return stop_ || !inbox_.empty(); });
    if (stop_) return;
    if (idle) {
      // The chip sends its modem's state whenever its latency has passed.
      lock.unlock();
      if (UsbBus::Get().Waiting(place_.load()) == 0)
        UsbBus::Get().Send(place_.load(), {0x01, 0x60});
      lock.lock();
      continue;
    }
    const Said said = std::move(inbox_.front());
    inbox_.pop_front();
    lock.unlock();
    switch (said.kind) {
      case Said::kRequest:
        OnRequest(said.request, said.value);
        break;
      case Said::kBytes:
        OnBytes(said.bytes);
        break;
      case Said::kPower:
        lights_ = 0;
        homed_ = false;
        runs_ = false;
        break;
    }
    lock.lock();
  }
}

void EmulatedFalcon::OnRequest(uint8_t request, uint16_t value) {
  if (request == kBaud) divisor_ = value;
  if (request == kLatency) latency_ms_ = value;
  if (request == kReset) frame_.clear();
  if (request == kModem && (value & 0x100) != 0) {
    const bool dtr = (value & 1) != 0;
    if (dtr && !dtr_) {
      is_reset_ = true;
      loader_ = Loader::kAwaitsHail;
      loaded_.clear();
    }
    dtr_ = dtr;
  }
}

void EmulatedFalcon::OnBytes(ByteView bytes) {
  if (!is_powered_) return;
  for (const uint8_t byte : bytes) {
    if (!runs_) {
      Load(byte);
    } else if (divisor_ == kBaudFrames) {
      if (byte == '<') frame_.clear();
      frame_.push_back(byte);
      if (byte == '>' && frame_.size() == 16 && frame_.front() == '<') TakeFrame();
    }
  }
}

// What the loader does with a byte on the line. At another speed than its own it understands none.
void EmulatedFalcon::Load(uint8_t byte) {
  loaded_.push_back(byte);
  if (loader_ == Loader::kAwaitsHail) {
    if (divisor_ == kBaud9600 && is_reset_ && loaded_ == Bytes{0x0a, 0x43, 0x0d}) {
      loaded_.clear();
      loader_ = Loader::kAwaitsBegin;
      Send(Bytes{0x0a, 0x44, 0x2c, 0x0d});
    } else if (loaded_.size() >= 3) {
      loaded_.clear();
    }
    return;
  }
  if (divisor_ != kBaudUpload || dtr_) return;
  if (loader_ == Loader::kAwaitsBegin) {
    loaded_.clear();
    if (byte != 0x41) return;
    loader_ = Loader::kTakes;
    ++uploads_;
    spoils_ = spoiled_ > 0;
    if (spoils_) --spoiled_;
    Send(Bytes{byte});
    return;
  }
  // As many as come at once are sent back at once, at the latest when the firmware is whole.
  if (loaded_.size() % 62 != 0 && loaded_.size() != firmware_.size()) return;
  const size_t begin = (loaded_.size() - 1) / 62 * 62;
  Bytes echo(loaded_.begin() + static_cast<std::ptrdiff_t>(begin), loaded_.end());
  if (spoils_ && begin == 62 * 2) echo[5] ^= 0x10;
  Send(echo);
  if (loaded_.size() < firmware_.size()) return;
  runs_ = loaded_ == firmware_;
  loader_ = Loader::kAwaitsHail;
  loaded_.clear();
}

void EmulatedFalcon::TakeFrame() {
  if (const auto wait = Wait(); wait.count() > 0) std::this_thread::sleep_for(wait);
  const auto nibble = [&](size_t at) { return frame_[at] - 'A'; };
  Bytes answer(16, 'A');
  {
    std::lock_guard lock(mutex_);
    ++requests_;
    const int state = nibble(13);
    lights_ = state & 14;
    if ((state & 1) != 0 && lights_ == 8 && homes_) homed_ = true;
    for (size_t i = 0; i < 3; ++i) {
      const size_t at = 1 + 4 * i;
      told_[i] = static_cast<int16_t>(nibble(at) | nibble(at + 1) << 4 | nibble(at + 2) << 8 |
                                      nibble(at + 3) << 12);
      for (size_t k = 0; k < 4; ++k) {
        answer[at + k] =
            static_cast<uint8_t>('A' + (static_cast<unsigned>(counts_[i]) >> (4 * k) & 15));
      }
    }
    answer.front() = '<';
    answer.back() = '>';
    // The worse of two that public clients expect: it tells where it is in homing mode only.
    answer[13] = static_cast<uint8_t>('A' + (homed_ && (state & 1) != 0 ? 0x70 : 0x10) + buttons_);
    if (lose_ >= 0) answer.erase(answer.begin() + lose_);
    answer = Through(std::move(answer));
  }
  if (answer.empty()) return;
  const size_t first = pieces_ ? answer.size() / 3 : 0;
  if (first > 0) Send(ByteView(answer).first(first));
  Send(ByteView(answer).subspan(first));
}

void EmulatedFalcon::Send(ByteView bytes) {
  Bytes packet{0x01, 0x60};
  packet.insert(packet.end(), bytes.begin(), bytes.end());
  UsbBus::Get().Send(place_.load(), packet);
}

}  // namespace enamel::station::testing_support
