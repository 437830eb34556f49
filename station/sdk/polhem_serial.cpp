#include <linux/serial.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "station/devices/trouble.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/device_file.h"
#include "station/sdk/frames.h"

// Polhem v3 on a serial port: a line of text with a force out, one with the tip in. The lines are those of
// forsslund/haptikfabrikenapi (uhaptikfabriken.h).
namespace enamel::station::sdk {
namespace {

constexpr size_t kSerialLine = 64;
// The driver keeps so much of a line that has not ended. An answer is a line, after at most a few empty ones.
constexpr size_t kMaxKept = 4 * kSerialLine, kMaxOfAnAnswer = 16 * kSerialLine;
constexpr std::string_view kTeensy = "16c0:";  // Teensy boards; their builds differ in the product
// The counters of an arm that is held at home, a to f (v3, since 2020-10-27).
constexpr std::array<int, 6> kSerialHome = {8298, -10771, 19756, 0, 30, 0};
enum Command { kSetCounters = 1, kForce = 2 };

struct Answer {
  std::array<double, 3> tip_mm{};
  std::array<double, 4> joints_rad{};  // a, lambda, d, e
  int info = 0;                        // 1: the calibration button was pressed
};

// A number with exactly so many decimals, from its field of `width` characters and a blank after it.
bool TakeNumber(std::string_view& line, size_t width, size_t decimals, double& out) {
  if (line.size() <= width || line[width] != ' ') return false;
  std::string_view field = line.substr(0, width);
  line.remove_prefix(width + 1);
  field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
  const size_t point = field.find('.');
  if (point == field.npos || field.size() - point - 1 != decimals) return false;
  const auto [end, error] =
      std::from_chars(field.data(), field.data() + field.size(), out, std::chars_format::fixed);
  return error == std::errc() && end == field.data() + field.size();
}

// Every column counts: a line that lost a byte on the way would be another place.
std::optional<Answer> Parse(std::string_view line) {
  Answer out;
  for (double& v : out.tip_mm) {
    if (!TakeNumber(line, 8, 3, v)) return std::nullopt;
  }
  for (double& v : out.joints_rad) {
    if (!TakeNumber(line, 7, 4, v)) return std::nullopt;
  }
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), out.info);
  if (error != std::errc()) return std::nullopt;
  line.remove_prefix(static_cast<size_t>(end - line.data()));
  if (line.find_first_not_of(" \r") != line.npos) return std::nullopt;
  return out;
}

Quat About(const dvec3& axis, double rad) {
  const dvec3 v = axis * std::sin(rad / 2);
  return {v.x, v.y, v.z, std::cos(rad / 2)};
}

class PolhemSerial final : public AnsweringBus {
 public:
  PolhemSerial(const BusChoice& choice, std::unique_ptr<Fd> port, std::string unit)
      : AnsweringBus(choice.peak_n, "plug it into this computer without a hub"),
        reach_m_(choice.reach_m),
        unit_(std::move(unit)),
        port_(std::move(port)) {
    SetUp();
  }

  std::string Name() const override { return "Polhem v3"; }
  std::string Driver() const override { return "polhem_serial"; }
  std::string Unit() const override { return unit_; }
  bool counts_from_power_up() const override { return true; }
  bool is_calibrated_anew() const override { return is_calibrated_anew_; }

 private:
  // A line may come in pieces. A port that sends without end, and no line, has answered what nobody
  // understands.
  Got Await(std::chrono::microseconds patience) override {
    const auto until = Clock::now() + patience;
    for (size_t bytes = 0; !TakeLine();) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
      pollfd ready{port_->get(), POLLIN, 0};
      if (::poll(&ready, 1, static_cast<int>(std::max<int64_t>(left.count(), 0))) == 0) {
        return Got::kNothing;
      }
      const auto got = Fill();
      if (!got) return Got::kClosed;
      bytes += *got;
      if (bytes > kMaxOfAnAnswer) {
        answer_.reset();
        return Got::kAnswer;
      }
      if (Clock::now() >= until && !HasLine()) return Got::kNothing;
    }
    return Got::kAnswer;
  }
  Heard Understand(Pose& out) override {
    if (!answer_) return Heard::kRefused;
    Take(*answer_, out);
    return Heard::kPose;
  }
  // An arm whose button was pressed before the session gets its counters.
  bool Ask(const dvec3& force_n) override {
    if (!is_ready_ && asks_for_home_) {
      is_calibrated_anew_ = true;
      return Write({kSerialHome[3], kSerialHome[4], kSerialHome[5], kSetCounters, kSerialHome[0],
                    kSerialHome[1], kSerialHome[2]});
    }
    const dvec3 mn = ToUserward(force_n) * 1e3;
    return Write({static_cast<int>(std::lround(mn.x)), static_cast<int>(std::lround(mn.y)),
                  static_cast<int>(std::lround(mn.z)), kForce, 0, 0, 0});
  }
  Result<bool> IsReady(Heard heard, const Pose& pose) override {
    if (heard != Heard::kPose || asks_for_home_) return false;
    ENAMEL_RETURN_IF_ERROR(
        CheckHome(Name(), pose.tip_m, reach_m_,
                  "hold its arm at the home pose and press its calibration button"));
    is_ready_ = true;
    return true;
  }

  void SetUp() {
    termios line{};
    if (::tcgetattr(port_->get(), &line) == 0) {
      ::cfmakeraw(&line);
      ::cfsetspeed(&line, B115200);
      ::tcsetattr(port_->get(), TCSANOW, &line);
    }
    // Where the driver knows it, it passes on each packet at once instead of every 16 ms.
    serial_struct serial{};
    if (::ioctl(port_->get(), TIOCGSERIAL, &serial) == 0) {
      serial.flags |= ASYNC_LOW_LATENCY;
      ::ioctl(port_->get(), TIOCSSERIAL, &serial);
    }
  }
  // Reads at most a piece. Returns the bytes read, 0 if none are there; nothing: the port is gone.
  std::optional<size_t> Fill() {
    std::array<char, 256> piece;
    const ssize_t got = ::read(port_->get(), piece.data(), piece.size());
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    if (got <= 0) return std::nullopt;
    text_.append(piece.data(), static_cast<size_t>(got));
    // What has no end of a line by now has none.
    if (text_.size() > kMaxKept) text_.erase(0, text_.size() - kMaxKept);
    return static_cast<size_t>(got);
  }
  bool HasLine() const { return text_.find('\n') != std::string::npos; }
  // The next line with a word: one without is what older firmware sends in between. False: none.
  bool TakeLine() {
    for (size_t end; (end = text_.find('\n')) != std::string::npos;) {
      const std::string line = text_.substr(0, end);
      text_.erase(0, end + 1);
      if (line.find_first_not_of(" \r") == line.npos) continue;
      answer_ = Parse(line);
      return true;
    }
    return false;
  }
  bool Write(const std::array<int, 7>& words) {
    std::array<char, kSerialLine + 1> line;
    int n = 0;
    for (const int word : words) {
      n += std::snprintf(line.data() + n, line.size() - static_cast<size_t>(n), "%d ", word);
    }
    std::fill(line.begin() + n, line.end(), ' ');
    line[kSerialLine - 1] = '\n';
    // A line that does not fit is lost, as on the cable: the next one follows within a millisecond.
    return ::write(port_->get(), line.data(), kSerialLine) >= 0 || errno == EAGAIN ||
           errno == EINTR;
  }
  void Take(const Answer& answer, Pose& out) {
    asks_for_home_ = answer.info == 1;
    out.tip_m = FromUserward({answer.tip_mm[0], answer.tip_mm[1], answer.tip_mm[2]}) * 1e-3;
    // Without the sixth joint, which is not on this line.
    const auto& rad = answer.joints_rad;
    const Quat q = About({0, 0, 1}, rad[0]) * About({0, 1, 0}, -rad[1]) * About({1, 0, 0}, rad[2]) *
                   About({0, 1, 0}, rad[3]);
    const dvec3 axis = FromUserward({q.x, q.y, q.z});
    out.orientation = {axis.x, axis.y, axis.z, q.w};
  }

  const double reach_m_;
  const std::string unit_;
  const std::unique_ptr<Fd> port_;
  std::string text_;  // what has come after the last whole line
  std::optional<Answer> answer_;
  bool asks_for_home_ = false, is_ready_ = false, is_calibrated_anew_ = false;
};

std::string UnitOf(const std::string& path) {
  const std::string place = UsbPlace(path);
  return place.empty() ? place : "polhem_serial:usb:" + place;
}

std::vector<std::string> Ports() {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& port : std::filesystem::directory_iterator("/sys/class/tty", error)) {
    const std::string name = port.path().filename(), path = "/dev/" + name;
    if (name.starts_with("ttyACM") && UsbIds(path).starts_with(kTeensy)) out.push_back(path);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenPolhemSerial(const BusChoice& choice) {
  std::string path = choice.address;
  if (path.empty()) {
    const auto ports = Ports();
    if (ports.empty()) {
      return Status(Code::kNotFound,
                    "no Polhem is attached to a serial port: plug it in, or name the port "
                    "(polhem_serial:/dev/ttyACM0)",
                    trouble::kNotAttached);
    }
    path = ports.front();
  }
  ENAMEL_ASSIGN_OR_RETURN(auto port, OpenAlone(path));
  auto bus = std::make_unique<PolhemSerial>(choice, std::move(port), UnitOf(path));
  ENAMEL_RETURN_IF_ERROR(bus->Open());
  return std::unique_ptr<PolledBus>(std::move(bus));
}

std::vector<SdkDevice> FindPolhemSerial() {
  std::vector<SdkDevice> out;
  for (const std::string& path : Ports()) {
    out.push_back({"", "Polhem v3 (" + path + ")", "polhem_v3", UsbIds(path), UnitOf(path),
                   OpenAlone(path).status()});
  }
  return out;
}

}  // namespace enamel::station::sdk
