#include "station/hid/haptic_board.h"

#include <time.h>

#include <algorithm>
#include <cmath>

#include "common/scene/cell.h"
#include "station/devices/trouble.h"

namespace enamel::station::hid {
namespace {

constexpr uint32_t kLateReports = 1000;  // up to this far back is late, farther is a restart
constexpr std::chrono::milliseconds kFirstReport{1000}, kStep{1};
// How soon an unplugged board's port is closed while no command to its spring comes.
constexpr int64_t kIdle_us = 100'000;
// After this time a board's reports must confirm that it drives its motors.
constexpr int64_t kTakesEffect_us = 20'000;
constexpr uint8_t kSixAxes = 6;
constexpr double kMaxTorque = 2e9;  // what the report holds, uN m

int64_t Now_us() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * int64_t{1'000'000} + t.tv_nsec / 1000;
}

// Within a tenth of unit length; anything else does not come from a sensor.
bool IsTurn(const std::array<int16_t, 4>& q) noexcept {
  constexpr double kUnit = 32767.0;
  double square = 0;
  for (int16_t v : q) square += static_cast<double>(v) * v;
  return square > 0.81 * kUnit * kUnit && square < 1.21 * kUnit * kUnit;
}

int32_t Saturated(int64_t v) noexcept {
  return static_cast<int32_t>(std::clamp<int64_t>(v, INT32_MIN, INT32_MAX));
}

// In 0.1 mN. Beyond the peak on any axis all axes are reduced by the same share: clipping each axis
// would change the direction of the push.
std::array<int32_t, 3> WithinPeak(const dvec3& force_n, const FeatureReport& board) {
  const dvec3 force = force_n * 1e4;
  double share = 1;
  for (int i = 0; i < 3; ++i) {
    const double peak = board.peak_force_mn[static_cast<size_t>(i)] * 10.0;
    if (std::abs(force[i]) > peak) share = std::min(share, peak / std::abs(force[i]));
  }
  std::array<int32_t, 3> out{};
  for (int i = 0; i < 3; ++i) {
    out[static_cast<size_t>(i)] = static_cast<int32_t>(std::lround(force[i] * share));
  }
  return out;
}

}  // namespace

Result<FeatureReport> AskFeature(HidPort& port) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, port.GetFeature(kFeatureId, kFeatureBytes));
  FeatureReport feature;
  ReportError error = DecodeFeature(bytes, feature);
  if (error == ReportError::kNone) return feature;
  return Status(error == ReportError::kVersion ? Code::kVersion : Code::kInvalidInput,
                std::string("what the board says of itself (feature report 0x44) is ") +
                    ReportErrorText(error),
                "device");
}

ReportOrder::Verdict ReportOrder::Judge(uint32_t sequence) noexcept {
  // Modulo 2^32, so that the number may wrap.
  uint32_t ahead = sequence - last_, behind = last_ - sequence;
  if (!has_last_) {
    has_last_ = true;
    last_ = sequence;
    return Verdict::kNew;
  }
  if (ahead == 0) return Verdict::kDuplicate;
  if (behind <= kLateReports) return Verdict::kLate;
  // Ahead by more than half the range means behind, and too far to be late: a restart.
  bool restarted = ahead > UINT32_MAX / 2;
  if (!restarted) lost_ += ahead - 1;
  last_ = sequence;
  return restarted ? Verdict::kRestarted : Verdict::kNew;
}

Result<std::unique_ptr<HapticBoard>> HapticBoard::Open(const HapticBoardSettings& settings) {
  HidMatch match = settings.match;
  // The collection identifies our reports; ids only select among several boards.
  match.usage_page = kBoardUsagePage;
  match.usage = kBoardUsage;
  ENAMEL_ASSIGN_OR_RETURN(auto info, FindHid(match));
  ENAMEL_ASSIGN_OR_RETURN(auto port, HidPort::Open(info.path));
  ENAMEL_ASSIGN_OR_RETURN(auto feature, AskFeature(*port));
  std::unique_ptr<HapticBoard> board(new HapticBoard(settings, info, std::move(feature)));
  for (auto waited = kStep; waited <= kFirstReport; waited += kStep) {
    if (board->samples_ > 0) return board;
    std::this_thread::sleep_for(kStep);
  }
  return Status(Code::kUnavailable,
                board->name_ + " says what it is and sends no pose within a second (" +
                    std::to_string(board->refused_.load()) +
                    " reports were refused): plug it in again",
                trouble::kSilent);
}

std::string UnitOf(const HidInfo& info) {
  if (info.serial.empty()) return {};
  return "hid:" + HidMatch{info.vendor, info.product, info.serial, 0, 0}.Text();
}

HapticBoard::HapticBoard(const HapticBoardSettings& settings, const HidInfo& info,
                         FeatureReport feature)
    : settings_(settings),
      feature_(std::move(feature)),
      serial_(info.serial),
      name_(feature_.name.empty() ? info.name : feature_.name),
      unit_(UnitOf(info)),
      watchdog_ms_(std::clamp(settings.watchdog_ms, 1, int{feature_.max_watchdog_ms})) {
  HidMatch again{info.vendor, info.product, info.serial, kBoardUsagePage, kBoardUsage};
  // The writer first: the reader may find a board at once and pass it a port.
  writer_ = std::thread([this] { Write(); });
  reader_.reset(new HidReader(again, *this));
}

HapticBoard::~HapticBoard() {
  // The reader first, because it calls into the rest. The writer's last act is force 0 and motors
  // off.
  reader_.reset();
  stop_ = true;
  force_signal_.Post();
  writer_.join();
}

DeviceSample HapticBoard::ReadSample() noexcept {
  const Pose& newest = poses_.Read();
  DeviceSample sample = newest.sample;
  // Fresh once: data seen in the last tick is no longer new.
  sample.fresh = sample.fresh && newest.number != seen_;
  seen_ = newest.number;
  // Counters instead of flags: an event that began and ended between two ticks still counts.
  if (newest.breaks != seen_breaks_) sample.attached = sample.fresh = false;
  seen_breaks_ = newest.breaks;
  if (newest.switch_offs != seen_switch_offs_) sample.driven = false;
  seen_switch_offs_ = newest.switch_offs;
  return sample;
}

void HapticBoard::SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept {
  Post({force_n, torque_n_m, ++sent_, false, {}});
}

void HapticBoard::SendSpring(const SpringCommand& command) noexcept {
  Post({dvec3(0), dvec3(0), ++sent_, true, command});
}

void HapticBoard::Post(const Force& force) noexcept {
  forces_.Write(force);
  force_signal_.Post();
}

DeviceCounters HapticBoard::counters() const noexcept {
  return {samples_, lost_, duplicated_, refused_, writes_, write_errors_, detached_};
}

bool HapticBoard::OnAttached(const HidInfo& info) {
  // The reader's thread belongs to HidReader: this is its first call here.
  if (settings_.thread_setup && published_ == 0) settings_.thread_setup();
  if (info.serial != serial_) return false;
  // A separate handle for the writer.
  auto port = HidPort::Open(info.path);
  if (!port.ok()) return false;
  auto feature = AskFeature(**port);
  if (!feature.ok() || *feature != feature_) return false;
  // After plugging in, its count may start anywhere.
  order_.Forget();
  must_be_near_ = published_ > 0;
  {
    MutexLock lock(port_mutex_);
    new_port_ = std::move(*port);
  }
  attached_ = true;
  return true;
}

void HapticBoard::OnDetached() {
  attached_ = false;
  new_clock_ = true;
  ++breaks_;
  ++detached_;
  // An unplugged board's pedal counts as released. Its pose stays: the tick needs one.
  sample_.buttons = 0;
  sample_.bur_speed_krpm = 0;
  PublishPose(false);
}

void HapticBoard::OnReport(ByteView bytes) {
  InputReport report;
  if (DecodeInput(bytes, report) != ReportError::kNone) {
    ++refused_;
    return;
  }
  switch (order_.Judge(report.sequence)) {
    case ReportOrder::Verdict::kDuplicate:
    case ReportOrder::Verdict::kLate:
      ++duplicated_;
      return;
    case ReportOrder::Verdict::kRestarted:
      ++breaks_;
      new_clock_ = must_be_near_ = true;
      break;
    case ReportOrder::Verdict::kNew:
      break;
  }
  lost_ = order_.lost();
  TakeReport(report);
  PublishPose(true);
  ++samples_;
}

void HapticBoard::TakeReport(const InputReport& report) {
  // Once: a board plugged in again keeps its middle, or the scene would move.
  if (!centred_ && settings_.centre_on_first_report) centre_ = report.counts;
  centred_ = true;
  std::array<int32_t, 3> counts, rest_nm;
  for (size_t i = 0; i < 3; ++i) {
    counts[i] = Saturated(int64_t{report.counts[i]} - centre_[i]);
    rest_nm[i] = Saturated(report.rest_nm[i] - MiddleNm(i));
  }
  sample_.counts = settings_.axes.ToScene(counts);
  sample_.rest_nm = settings_.axes.ToScene(rest_nm);
  sample_.share = report.share;
  if ((report.status & kOrientationValid) && IsTurn(report.orientation)) {
    sample_.orientation = ToQuantised(settings_.axes.ToScene(FromQuantised(report.orientation)));
  }
  sample_.buttons = 0;
  if (report.buttons & 1) sample_.buttons |= kPedal;
  if (report.buttons & 2) sample_.buttons |= kPutDown;
  if (report.buttons & 4) sample_.buttons |= kSecond;
  bool down = (sample_.buttons & kPedal) != 0;
  uint16_t speed = report.bur_speed_krpm != 0 ? report.bur_speed_krpm : kTurbineSpeed_krpm;
  sample_.bur_speed_krpm = down ? speed : uint16_t{0};
  JudgePlace(report);
  sample_.attached = (report.status & kNotFit) == 0 && !misplaced_;
  breaks_ += !sample_.attached;
  sample_.driven = !SwitchedOff(report.status);
  switch_offs_ += !sample_.driven;
  sample_.sequence = report.sequence;
  // The station's copy of the device's time stops during a restart and never goes back.
  if (new_clock_) last_time_us_ = report.time_us;
  new_clock_ = false;
  sample_.device_time_us += report.time_us - last_time_us_;  // modulo 2^32: it wraps
  last_time_us_ = report.time_us;
}

void HapticBoard::JudgePlace(const InputReport& report) {
  if ((report.status & kNotFit) != 0) {
    misplaced_ = must_be_near_ = false;
    return;
  }
  if (must_be_near_) {
    dvec3 moved_m(0);
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<size_t>(i);
      moved_m[i] =
          (static_cast<double>(report.counts[a]) - trusted_[a]) * feature_.resolution_nm[a] * 1e-9;
    }
    misplaced_ = Dot(moved_m, moved_m) > kFar_m * kFar_m;
    must_be_near_ = false;
  }
  if (!misplaced_) trusted_ = report.counts;
}

Status HapticBoard::problem() const {
  if (!misplaced_) return Status::Ok();
  return Status(Code::kUnavailable,
                name_ + " may have lost its place with its power: home it, and continue",
                trouble::kLost);
}

// Applies only after the motors were requested: the board starts with them off, and its watchdog
// may not have been fed for long. Ignores reports that were already on the way.
bool HapticBoard::SwitchedOff(uint8_t status) {
  const int64_t first_us = first_driven_us_;
  if (first_us == 0) return false;
  // Reports already on the way when the motors were requested or released describe the previous
  // state. After every turn the board has to report them on before a report of off counts.
  const uint32_t turns = turns_;
  if (turns != seen_turns_) said_on_ = false;
  seen_turns_ = turns;
  const bool on = (status & kMotorsOn) != 0, tripped = (status & kWatchdogTripped) != 0;
  const bool must_be_fed = said_fed_ || Now_us() - first_us > kTakesEffect_us;
  const bool off = (said_on_ && !on) || (must_be_fed && tripped);
  said_on_ = turns % 2 == 1 && (said_on_ || on);
  said_fed_ = said_fed_ || !tripped;
  return off;
}

void HapticBoard::PublishPose(bool fresh) {
  sample_.fresh = fresh;
  if (!attached_) sample_.attached = false;
  poses_.Write({sample_, ++published_, breaks_, switch_offs_});
}

void HapticBoard::TakePort(std::unique_ptr<HidPort>& port) {
  MutexLock lock(port_mutex_);
  if (new_port_ != nullptr) {
    port = std::move(new_port_);
  } else if (!attached_) {
    port.reset();
  }
}

void HapticBoard::Write() {
  if (settings_.thread_setup) settings_.thread_setup();
  ForceKeeper keeper(watchdog_ms_);
  std::unique_ptr<HidPort> port;
  uint32_t sequence = 0;
  uint64_t spring_sent = 0;
  while (!stop_) {
    // At least 0.1 ms, or a keeper with a due repeat would spin on a detached board.
    const bool to_spring = forces_.Read().to_spring;
    force_signal_.Wait(to_spring ? kIdle_us : std::max<int64_t>(keeper.WaitFor_us(Now_us()), 100));
    TakePort(port);
    Force newest = forces_.Read();
    int64_t now = Now_us();
    if (newest.to_spring) {
      if (newest.number != spring_sent && port != nullptr) Send(*port, newest.spring, ++sequence);
      spring_sent = newest.number;
      continue;
    }
    keeper.Take(newest.newtons, newest.number, now, newest.newton_metres);
    auto command = keeper.Next(now);
    if (command && port != nullptr) Send(*port, *command, ++sequence);
  }
  TakePort(port);
  if (port != nullptr) Send(*port, ForceKeeper::Command{}, ++sequence);
}

bool HapticBoard::Send(HidPort& port, const ForceKeeper::Command& command, uint32_t sequence) {
  OutputReport report;
  report.motors_on = command.motors_on;
  report.sequence = sequence;
  report.watchdog_ms = static_cast<uint16_t>(watchdog_ms_);
  report.force_100un = WithinPeak(settings_.axes.ToBoard(command.force_n), feature_);
  if (feature_.axes == kSixAxes) {
    // Turned like a force: the axes are rotated, never mirrored (AxisMap).
    const dvec3 torque_un_m = settings_.axes.ToBoard(command.torque_n_m) * 1e6;
    for (int i = 0; i < 3; ++i) {
      report.torque_un_m[static_cast<size_t>(i)] =
          Saturated(std::llround(std::clamp(torque_un_m[i], -kMaxTorque, kMaxTorque)));
    }
  }
  return Put(port, EncodeOutput(report), command.motors_on);
}

bool HapticBoard::Send(HidPort& port, SpringCommand command, uint32_t sequence) {
  const dvec3 rest =
      settings_.axes.ToBoard(dvec3(command.rest_nm[0], command.rest_nm[1], command.rest_nm[2]));
  for (size_t i = 0; i < 3; ++i)
    command.rest_nm[i] = Saturated(std::llround(rest[static_cast<int>(i)]) + MiddleNm(i));
  command.added_n = settings_.axes.ToBoard(command.added_n);
  command.torque_n_m =
      feature_.axes == kSixAxes ? settings_.axes.ToBoard(command.torque_n_m) : dvec3(0);
  return Put(port, EncodeSpring(ReportOf(command, sequence)), true);
}

int64_t HapticBoard::MiddleNm(size_t board_axis) const noexcept {
  return int64_t{centre_[board_axis]} * feature_.resolution_nm[board_axis];
}

bool HapticBoard::Put(HidPort& port, ByteView report, bool motors_on) {
  // Before the write, so that the board's answer finds the new state.
  if (motors_on != (turns_ % 2 == 1)) ++turns_;
  if (motors_on && first_driven_us_ == 0) first_driven_us_ = Now_us();
  bool written = port.Write(report);
  ++(written ? writes_ : write_errors_);
  return written;
}

namespace {

Status NotAsNeeded(const std::string& found, const std::string& expected, const std::string& todo,
                   const char* field) {
  return Status(Code::kConflict, found + ", " + expected + ": " + todo, field);
}

std::string SpringText(int64_t kc_mn_per_mm, int64_t rate_hz, int64_t delay_ticks) {
  return "a spring of " + std::to_string(kc_mn_per_mm) + " mN/mm at " + std::to_string(rate_hz) +
         " Hz with " + std::to_string(delay_ticks) + " ticks of delay";
}

// What the profile's clause was computed with is what the board runs.
Status CheckSpring(const FeatureReport& board, const scene::DeviceProfile& profile) {
  if (!profile.board_spring) return Status::Ok();
  const scene::BoardSpringSpec& spring = *profile.board_spring;
  if (board.spring_kc_mn_per_mm == profile.coupling_mn_per_mm.value &&
      board.spring_rate_hz == spring.rate_hz && board.spring_delay_ticks == spring.delay_ticks) {
    return Status::Ok();
  }
  const std::string needed =
      "device profile '" + profile.name + "' says " +
      SpringText(profile.coupling_mn_per_mm.value, spring.rate_hz, spring.delay_ticks);
  if (!board.runs_spring()) {
    return NotAsNeeded(board.name + " runs no spring", needed,
                       "choose a profile without board_spring", "board_spring");
  }
  const std::string found =
      SpringText(board.spring_kc_mn_per_mm, board.spring_rate_hz, board.spring_delay_ticks);
  return NotAsNeeded(board.name + " runs " + found, needed,
                     "set coupling_mn_per_mm and board_spring to the board's, if its damping and "
                     "friction carry them",
                     "board_spring");
}

}  // namespace

Status CheckBoard(const FeatureReport& board, const scene::DeviceProfile& profile,
                  uint32_t rate_hz) {
  const std::string own = board.profile.empty() ? "" : " ('" + board.profile + "')";
  const std::string says = "device profile '" + profile.name + "' says ";
  for (size_t i = 0; i < 3; ++i) {
    const std::string axis = " on axis " + std::to_string(i + 1);
    if (board.resolution_nm[i] != static_cast<uint64_t>(scene::CountNm(profile))) {
      return NotAsNeeded(
          board.name + " has counts of " + std::to_string(board.resolution_nm[i]) + " nm" + axis,
          says + std::to_string(scene::CountNm(profile)),
          "choose its own profile" + own + ", or let 'enamel-station calibrate' propose one",
          "resolution_nm");
    }
    if (static_cast<int64_t>(board.peak_force_mn[i]) < profile.peak_force_mn.value) {
      return NotAsNeeded(
          board.name + " reaches " + std::to_string(board.peak_force_mn[i]) + " mN" + axis,
          says + std::to_string(profile.peak_force_mn.value),
          "choose its own profile" + own + ", or let 'enamel-station calibrate' propose one",
          "peak_force_mn");
    }
  }
  ENAMEL_RETURN_IF_ERROR(CheckSpring(board, profile));
  if (profile.torque && (board.axes != kSixAxes || !board.tells_orientation)) {
    return NotAsNeeded(
        board.name + " drives " + std::to_string(board.axes) + " axes and " +
            (board.tells_orientation ? "reports" : "does not report") + " its orientation",
        says + "6 with torque", "choose its own profile" + own + ", or one without torque", "axes");
  }
  if (board.rate_hz < rate_hz) {
    return NotAsNeeded(
        board.name + " says where it is " + std::to_string(board.rate_hz) + " times a second",
        "the exercise needs it " + std::to_string(rate_hz) + " times",
        "choose an exercise with a rate of at most " + std::to_string(board.rate_hz) +
            " Hz (500 Hz is the lowest there is), or set the board to a higher rate if it has one",
        "rate_hz");
  }
  return Status::Ok();
}

}  // namespace enamel::station::hid
