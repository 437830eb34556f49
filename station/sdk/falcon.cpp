#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "common/base/file.h"
#include "station/devices/trouble.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/falcon_arm.h"
#include "station/sdk/frames.h"
#include "station/sdk/usb_port.h"

// Novint's Falcon: a serial line behind an FTDI chip, on which its firmware is loaded after each power-up, and then a frame
// of text with motor values out, one with encoder counts in. The bytes are those of libnifalcon (FalconCommLibUSB.cpp,
// FalconFirmware.cpp, FalconFirmwareNovintSDK.cpp).
namespace enamel::station::sdk {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr uint16_t kVendor = 0x0403, kProduct = 0xcb48;
constexpr const char* kIds = "0403:cb48";
constexpr uint8_t kEndpointIn = 0x81, kEndpointOut = 0x02;
constexpr const char* kName = "Novint Falcon";
constexpr const char* kFirmwareFile = "/etc/enamel/falcon.bin";
// Known files have 7 to 9 kB.
constexpr size_t kMaxFirmware = 64 * 1024;

// The chip's requests and their values.
enum Request : uint8_t { kReset = 0, kModem = 1, kFlow = 2, kBaud = 3, kData = 4, kLatency = 9 };
constexpr uint16_t kPurgeIn = 1, kPurgeOut = 2;
constexpr uint16_t kDtrLow = 0x100, kDtrHigh = 0x101, kRtsLow = 0x200;
constexpr uint16_t kNoFlow = 0, kEightBits = 8;
constexpr uint16_t kBaud9600 = 0x4138, kBaudUpload = 0x15, kBaudFrames = 0x2;  // divisors
constexpr uint16_t kLatencyUpload_ms = 16, kLatencyFrames_ms = 1;
constexpr size_t kModemBytes = 2;  // at the head of each packet

const Bytes kHail = {0x0a, 0x43, 0x0d}, kHailed = {0x0a, 0x44, 0x2c, 0x0d}, kBegin = {0x41};
constexpr int kMaxHails = 100, kMaxUploads = 10, kMaxProbes = 10;
constexpr size_t kPiece = 62;
// The chip passes on what came after 16 ms, or 1 ms in frames.
constexpr milliseconds kEchoPatience{200}, kHailPatience{20}, kProbePatience{30}, kQuiet{10};
// Bounds for a line that never falls quiet. DropUntilQuiet drops so many bytes. So many packets without a
// frame are an answer that nobody understands; a frame comes in one packet, or in two.
constexpr size_t kMaxDropped = 64 * 1024;
constexpr int kMaxOfAnAnswer = 8;
constexpr std::chrono::seconds kSilence{1};

// A frame: '<', three words of four signs each, lowest nibble first, a state, 'A', '>'.
constexpr size_t kFrame = 16, kState = 13;
constexpr uint8_t kZero = 'A', kFrameBegin = '<', kFrameEnd = '>';
enum : uint8_t { kHoming = 1, kLightBlue = 4, kLightRed = 8 };  // to the device
constexpr int kCentreButton = 4, kHomed = 0x70;                 // from it
// A motor value for a thigh's torque, against the angle; libnifalcon's comments cap the values there.
constexpr double kValuesPerNewtonMetre = -10'000, kMaxValue = 4'096;

struct Answer {
  std::array<int16_t, 3> counts{};
  bool pedal = false, homed = false;
};

std::optional<Answer> Parse(ByteView frame) {
  if (frame.size() != kFrame || frame.front() != kFrameBegin) return std::nullopt;
  Answer out;
  for (size_t i = 0; i < 3; ++i) {
    unsigned word = 0;
    for (size_t nibble = 0; nibble < 4; ++nibble) {
      const int value = frame[1 + 4 * i + nibble] - kZero;
      if (value < 0 || value > 15) return std::nullopt;
      word |= static_cast<unsigned>(value) << (4 * nibble);
    }
    out.counts[i] = static_cast<int16_t>(word);
  }
  const int state = frame[kState] - kZero;
  if (state < 0) return std::nullopt;
  out.pedal = (state & kCentreButton) != 0;
  out.homed = (state & kHomed) == kHomed;
  return out;
}

// The homing bit is in each frame. Public clients of libnifalcon differ: many keep it and note that the
// counters need it, some clear it once the device is homed. Keeping it serves both.
Bytes FrameOf(const std::array<int16_t, 3>& motors, uint8_t lights) {
  Bytes out(kFrame, kZero);
  out.front() = kFrameBegin;
  out.back() = kFrameEnd;
  for (size_t i = 0; i < 3; ++i) {
    const auto word = static_cast<uint16_t>(motors[i]);
    for (size_t nibble = 0; nibble < 4; ++nibble) {
      out[1 + 4 * i + nibble] = static_cast<uint8_t>(kZero + (word >> (4 * nibble) & 0xF));
    }
  }
  out[kState] = static_cast<uint8_t>(kZero + (lights | kHoming));
  return out;
}

// The serial line.
class Line {
 public:
  explicit Line(std::unique_ptr<UsbPort> port) : port_(std::move(port)) {}

  bool Set(Request request, uint16_t value) { return port_->Control(request, value); }
  bool Write(ByteView bytes) { return port_->Write(bytes); }
  bool Purge() {
    if (!Set(kReset, kPurgeIn) || !Set(kReset, kPurgeOut)) return false;
    DropUntilQuiet(milliseconds(0));  // what this computer had already read
    return true;
  }
  // Drops what has come and comes, until nothing does for so long, or the device never ceases.
  void DropUntilQuiet(milliseconds quiet) {
    for (size_t dropped = 0; dropped < kMaxDropped && Fill(quiet) == Got::kBytes;) {
      dropped += came_.size();
      came_.clear();
    }
    came_.clear();
  }
  // A packet with bytes on it, after those that came and were not taken. kNothing: none in time.
  enum class Got { kBytes, kNothing, kClosed };
  Got Fill(std::chrono::microseconds patience) {
    const auto until = Clock::now() + patience;
    std::array<uint8_t, UsbPort::kPacketBytes> packet;
    for (;;) {
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - Clock::now());
      const int got = port_->Read(packet, std::max(left, std::chrono::microseconds(0)));
      if (got < 0) return Got::kClosed;
      if (got > static_cast<int>(kModemBytes)) {
        came_.insert(came_.end(), packet.begin() + kModemBytes, packet.begin() + got);
        return Got::kBytes;
      }
      // An empty packet of the chip's does not count: it sends one every millisecond.
      if (Clock::now() >= until) return Got::kNothing;
    }
  }
  // Whether just these bytes come.
  Got Expect(ByteView bytes, milliseconds patience) {
    const auto until = Clock::now() + patience;
    while (came_.size() < bytes.size()) {
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - Clock::now());
      if (const Got got = Fill(left); got != Got::kBytes) return got;
    }
    const bool same = std::ranges::equal(came_, bytes);
    came_.clear();
    return same ? Got::kBytes : Got::kNothing;
  }
  // The next frame, or what a damaged one left. No sign within it is its first or last one.
  std::optional<Bytes> TakeFrame() {
    const auto end = std::ranges::find(came_, kFrameEnd);
    if (end == came_.end()) {
      // What has no end by now has none.
      if (came_.size() > 4 * kFrame) came_.clear();
      return std::nullopt;
    }
    const auto last = end + 1;
    auto begin = std::find(std::make_reverse_iterator(last), came_.rend(), kFrameBegin).base();
    if (begin != came_.begin()) --begin;
    Bytes out(begin, last);
    came_.erase(came_.begin(), last);
    return out;
  }

 private:
  std::unique_ptr<UsbPort> port_;
  Bytes came_;
};

bool SetForFrames(Line& line) {
  return line.Set(kLatency, kLatencyFrames_ms) && line.Set(kBaud, kBaudFrames) && line.Purge();
}

// Whether firmware runs that answers a frame.
bool IsLoaded(Line& line) {
  for (int i = 0; i < kMaxProbes; ++i) {
    if (!line.Write(FrameOf({}, 0))) return false;
    const auto until = Clock::now() + kProbePatience;
    while (Clock::now() < until && line.Fill(kProbePatience) == Line::Got::kBytes) {
      while (const auto frame = line.TakeFrame()) {
        if (Parse(*frame)) return true;
      }
    }
  }
  return false;
}

enum class Upload { kDone, kSilent, kDamaged };

// The loader in the device's memory takes firmware after these lines and bytes, and sends each byte back.
Upload TryUpload(Line& line, ByteView firmware) {
  if (!line.Purge() || !line.Set(kLatency, kLatencyUpload_ms) || !line.Set(kBaud, kBaud9600) ||
      !line.Set(kData, kEightBits) || !line.Set(kFlow, kNoFlow) || !line.Set(kModem, kRtsLow) ||
      !line.Set(kModem, kDtrLow) || !line.Set(kModem, kDtrHigh)) {
    return Upload::kSilent;
  }
  bool hailed = false;
  for (int i = 0; i < kMaxHails && !hailed; ++i) {
    if (!line.Write(kHail)) return Upload::kSilent;
    const Line::Got got = line.Expect(kHailed, kHailPatience);
    if (got == Line::Got::kClosed) return Upload::kSilent;
    hailed = got == Line::Got::kBytes;
  }
  if (!hailed || !line.Set(kModem, kDtrLow) || !line.Set(kBaud, kBaudUpload)) {
    return Upload::kSilent;
  }
  const auto echoed = [&](ByteView bytes) {
    return line.Write(bytes) && line.Expect(bytes, kEchoPatience) == Line::Got::kBytes;
  };
  if (!echoed(kBegin)) return Upload::kDamaged;
  for (size_t at = 0; at < firmware.size(); at += kPiece) {
    if (!echoed(firmware.subspan(at, std::min(kPiece, firmware.size() - at)))) {
      return Upload::kDamaged;
    }
  }
  return Upload::kDone;
}

Result<Bytes> ReadFirmware(const std::string& file) {
  auto firmware = ReadFile(file, kMaxFirmware);
  if (firmware.ok() && !firmware->empty()) return firmware;
  return Status(Code::kUnavailable,
                "firmware missing: put Novint's firmware into " + file +
                    ", or name its file (falcon:/FOLDER/FILE)" +
                    (firmware.ok() ? "; the file is empty" : "; " + firmware.status().message()),
                trouble::kFirmware);
}

Status LoadFirmware(Line& line, const std::string& file) {
  ENAMEL_ASSIGN_OR_RETURN(const Bytes firmware, ReadFirmware(file));
  Upload upload = Upload::kDamaged;
  for (int i = 0; i < kMaxUploads && upload == Upload::kDamaged; ++i) {
    upload = TryUpload(line, firmware);
  }
  // No loader answers where firmware runs that was late for each of the probes.
  if (upload != Upload::kDamaged && SetForFrames(line) && IsLoaded(line)) return Status::Ok();
  if (upload == Upload::kSilent) return SaysNothing(kName);
  return Status(
      Code::kUnavailable,
      std::string(kName) + (upload == Upload::kDone
                                ? " does not run the firmware of " + file +
                                      ": take another file, switch it off and on"
                                : " did not take its firmware in ten tries: switch it off "
                                  "and on, and plug it into this computer without a hub"),
      trouble::kFirmware);
}

std::string UnitOf(const UsbInfo& info) { return "falcon:usb:" + info.place; }

class Falcon final : public AnsweringBus {
 public:
  Falcon(const BusChoice& choice, Line line, std::string unit)
      : AnsweringBus(choice.peak_n, "plug it into this computer without a hub"),
        reach_m_(choice.reach_m),
        for_hand_(choice.for_hand),
        unit_(std::move(unit)),
        line_(std::move(line)) {}
  // No firmware is known to switch the motors off when it hears nothing: so this is said last, whatever
  // was before. Twice: a frame that the chip does not take in time is lost.
  ~Falcon() override {
    for (int i = 0; i < 2; ++i) (void)line_.Write(FrameOf({}, 0));
  }

  std::string Name() const override { return kName; }
  std::string Driver() const override { return "falcon"; }
  std::string Unit() const override { return unit_; }

  // Loads the firmware of `file` if none runs, awaits the person's hand, and then opens it. Errors:
  // as AnsweringBus::Open; kUnavailable, with what to do.
  Status Begin(const std::string& file) {
    if (!SetForFrames(line_)) return SaysNothing(kName);
    if (!IsLoaded(line_)) ENAMEL_RETURN_IF_ERROR(LoadFirmware(line_, file));
    // An answer to a question before would be taken for the next one's.
    line_.DropUntilQuiet(kQuiet);
    ENAMEL_RETURN_IF_ERROR(AwaitHomed());
    return Open();
  }

 private:
  Got Await(std::chrono::microseconds patience) override {
    const auto until = Clock::now() + patience;
    for (int packets = 0; !(frame_ = line_.TakeFrame()); ++packets) {
      if (packets == kMaxOfAnAnswer) {
        frame_.emplace();
        return Got::kAnswer;
      }
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - Clock::now());
      switch (line_.Fill(std::max(left, std::chrono::microseconds(0)))) {
        case Line::Got::kBytes:
          break;
        case Line::Got::kNothing:
          return Got::kNothing;
        case Line::Got::kClosed:
          return Got::kClosed;
      }
    }
    return Got::kAnswer;
  }
  Heard Understand(Pose& out) override {
    const auto answer = Parse(*frame_);
    is_frame_ = answer.has_value();
    if (!answer) return Heard::kRefused;
    // Firmware that restarts is not homed, and its counts mean nothing.
    if (!answer->homed) return homed_ ? Heard::kGone : Heard::kRefused;
    homed_ = true;
    dvec3 angles_rad;
    for (int i = 0; i < 3; ++i) {
      angles_rad[i] =
          falcon::kRadAtZero + falcon::kRadPerCount * answer->counts[static_cast<size_t>(i)];
    }
    const auto tip_m = falcon::TipOf(angles_rad, tip_m_);
    if (!tip_m) return Heard::kRefused;
    tip_m_ = *tip_m;
    angles_rad_ = angles_rad;
    const dvec3 from_middle = tip_m_ - falcon::kMiddle_m;
    out.tip_m = {from_middle.x, -from_middle.z, from_middle.y};
    out.pedal = answer->pedal;
    return Heard::kPose;
  }
  bool Ask(const dvec3& force_n) override {
    if (!homed_) return line_.Write(FrameOf({}, kLightRed));
    return line_.Write(FrameOf(MotorsOf(force_n), kLightBlue));
  }
  Result<bool> IsReady(Heard heard, const Pose& pose) override {
    if (heard != Heard::kPose) return false;
    ENAMEL_RETURN_IF_ERROR(
        CheckHome(kName, pose.tip_m, reach_m_,
                  "switch it off and on, then pull its grip out and push it in"));
    return true;
  }

  // Beyond what a motor is sent all three fall by the same share, so that the push keeps its direction.
  std::array<int16_t, 3> MotorsOf(const dvec3& f) const {
    std::array<int16_t, 3> out{};
    const auto torques_n_m = falcon::TorquesOf({f.x, f.z, -f.y}, tip_m_, angles_rad_);
    if (!torques_n_m) return out;
    const dvec3 values = *torques_n_m * kValuesPerNewtonMetre;
    const double most = std::max({std::abs(values.x), std::abs(values.y), std::abs(values.z)});
    const double share = std::min(1.0, kMaxValue / std::max(most, 1.0));
    for (int i = 0; i < 3; ++i) {
      out[static_cast<size_t>(i)] = static_cast<int16_t>(std::lround(values[i] * share));
    }
    return out;
  }
  // The firmware finds the thighs' places when the grip passes them, in homing mode.
  Status AwaitHomed() {
    const auto begin = Clock::now();
    auto heard_at = begin;
    while (!homed_) {
      Pose pose;
      if (!Send(dvec3(0))) return SaysNothing(kName);
      if (Read(pose) != Heard::kNothing && is_frame_) heard_at = Clock::now();
      if (Clock::now() - heard_at > kSilence) return SaysNothing(kName);
      if (!homed_ && Clock::now() - begin > for_hand_) {
        return Status(Code::kUnavailable,
                      std::string(kName) +
                          " is not calibrated: pull its grip out as far as it goes and push it in, "
                          "until its light is blue, and begin again",
                      trouble::kGrip);
      }
    }
    return Status::Ok();
  }

  const double reach_m_;
  const milliseconds for_hand_;
  const std::string unit_;
  Line line_;
  std::optional<Bytes> frame_;
  bool is_frame_ = false;  // the last answer was one
  bool homed_ = false;
  dvec3 tip_m_ = falcon::kMiddle_m, angles_rad_{falcon::kRadAtZero};
};

Result<Line> OpenLine(const UsbInfo& info) {
  ENAMEL_ASSIGN_OR_RETURN(auto port, UsbPort::Open(info, kEndpointIn, kEndpointOut));
  return Line(std::move(port));
}

// Why it cannot be used now, and what to do; empty: it can. Sends it frames of force 0.
Status WhyNotUsable(const UsbInfo& info, const std::string& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto line, OpenLine(info));
  if (!SetForFrames(line) || IsLoaded(line)) return Status::Ok();
  return ReadFirmware(file).status();
}

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenFalcon(const BusChoice& choice) {
  const auto attached = ListUsb(kVendor, kProduct);
  if (attached.empty()) {
    return Status(Code::kNotFound, "no Novint Falcon is attached: plug it in and switch it on",
                  trouble::kNotAttached);
  }
  const UsbInfo& info = attached.front();
  ENAMEL_ASSIGN_OR_RETURN(Line line, OpenLine(info));
  auto bus = std::make_unique<Falcon>(choice, std::move(line), UnitOf(info));
  ENAMEL_RETURN_IF_ERROR(
      bus->Begin(choice.address.empty() ? std::string(kFirmwareFile) : choice.address));
  return std::unique_ptr<PolledBus>(std::move(bus));
}

std::vector<SdkDevice> FindFalconWith(const std::string& file) {
  std::vector<SdkDevice> out;
  for (const UsbInfo& info : ListUsb(kVendor, kProduct)) {
    out.push_back({"", kName, "falcon", kIds, UnitOf(info), WhyNotUsable(info, file)});
  }
  return out;
}

std::vector<SdkDevice> FindFalcon() { return FindFalconWith(kFirmwareFile); }

}  // namespace enamel::station::sdk
