#include "station/app/doctor.h"

#include <sys/statvfs.h>
#include <time.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/program/output.h"
#include "common/scene/find_profile.h"
#include "station/devices/duration_histogram.h"
#include "station/devices/trouble.h"
#include "station/hid/haptic_board.h"
#include "station/hid/open_device.h"
#include "station/loop/realtime.h"
#include "station/render/screen.h"
#include "station/sdk/open_sdk_device.h"
#include "station/session/device_delay.h"
#include "station/spool/spool.h"
#include "station/uplink/policy_file.h"
#include "station/uplink/server_link.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

// 8 h of recording take up to 350 MB; a station must hold a week of them.
constexpr double kFewFree_gb = 5, kTooFewFree_gb = 0.5;
constexpr int64_t kClockOff_ms = 2'000, kClockWrong_ms = 60'000;
constexpr int kTimerTicks = 500;
constexpr int64_t kTick_ns = 1'000'000, kNsPerSecond = 1'000'000'000;

std::string Number(double v, const char* format) {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

Finding Enrolment(const DoctorCommand& options, Result<Credentials>& credentials) {
  credentials = LoadCredentialsFor(options.data, options.server);
  if (!credentials.ok()) {
    return {"enrolment", Verdict::kFail, credentials.status().message(), ""};
  }
  return {"enrolment", Verdict::kOk,
          "station " + credentials->name + " of " + credentials->server.Text(), ""};
}

Finding ServersClock(int64_t ahead_ms) {
  // In both directions: a clock ahead makes a valid ticket look expired, one behind an expired one
  // valid.
  const int64_t off = ahead_ms < 0 ? -ahead_ms : ahead_ms;
  // Milliseconds up to ten seconds, as far as the way to the server lets them be measured.
  const std::string by =
      off < 10'000 ? std::to_string(off) + " ms" : std::to_string(off / 1000) + " s";
  const std::string found =
      "the server's is " + by + (ahead_ms < 0 ? " behind" : " ahead of") + " this one";
  if (off <= kClockOff_ms) return {"clock", Verdict::kOk, found, ""};
  return {"clock", off <= kClockWrong_ms ? Verdict::kWarn : Verdict::kFail, found,
          "let the system keep time (systemd-timesyncd or chrony) on both: tickets are good for "
          "12 hours, an exam's for 10 minutes, and that is compared"};
}

void Server(const Result<Credentials>& credentials, std::vector<Finding>& out) {
  if (!credentials.ok()) {
    out.push_back({"server", Verdict::kWarn, "not asked: this station is not enrolled", ""});
    return;
  }
  ServerLink link;
  auto begin = steady_clock::now();
  Status status = link.Connect(*credentials);
  double ms = std::chrono::duration<double, std::milli>(steady_clock::now() - begin).count();
  if (!status.ok()) {
    const char* advice =
        status.code() == Code::kUnauthenticated
            ? "if the server was set up again, enrol again; else somebody intercepts the connection"
            : "check cable, address and that enamel-server runs; recordings made meanwhile are "
              "kept here";
    out.push_back({"server", Verdict::kFail, status.message(), advice});
    return;
  }
  std::string found =
      credentials->server.Text() + " answers, certificate as enrolled, " + Number(ms, "%.0f ms");
  if (link.may_begin_attempts()) {
    out.push_back({"server", Verdict::kOk, found, ""});
  } else {
    out.push_back({"server", Verdict::kFail, found + "; its core is another version",
                   "update this station or the server: until then it takes recordings only"});
  }
  out.push_back(ServersClock(link.server_ahead_ms()));
}

Finding Disk(const fs::path& data) {
  std::error_code error;
  fs::path place = fs::absolute(data, error);
  // The folder may not exist before enrolment; then its future disk is checked.
  while (!fs::exists(place, error) && place.has_relative_path()) place = place.parent_path();
  fs::path probe = place / (".enamel-doctor-" + std::to_string(::getpid()));
  auto begin = steady_clock::now();
  // With a sync, as for every chunk: finds a folder on a slow network drive here instead of in an
  // exam.
  Status written = WriteFileDurably(probe, Bytes(4096, 0x5a), 0600);
  double ms = std::chrono::duration<double, std::milli>(steady_clock::now() - begin).count();
  fs::remove(probe, error);
  if (!written.ok()) {
    return {"disk", Verdict::kFail, written.message(),
            "give this user the folder, or name another with --data"};
  }
  struct statvfs space {};
  double free_gb =
      ::statvfs(place.c_str(), &space) == 0
          ? static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize) * 1e-9
          : 0;
  std::string found = place.string() + ": " + Number(free_gb, "%.1f GB free, ") +
                      Number(ms, "a durable write takes %.1f ms");
  if (free_gb >= kFewFree_gb) return {"disk", Verdict::kOk, found, ""};
  return {"disk", free_gb < kTooFewFree_gb ? Verdict::kFail : Verdict::kWarn, found,
          "make room: a day of recording takes up to 0.35 GB, and it is kept for a week"};
}

Finding SpoolState(const fs::path& data) {
  std::error_code error;
  if (!fs::exists(data / "spool.sqlite", error)) {
    return {"spool", Verdict::kOk, "empty: nothing was recorded here yet", ""};
  }
  // To read only: a window may be recording into it.
  auto spool = Spool::OpenToRead(data);
  if (!spool.ok()) return {"spool", Verdict::kFail, spool.status().message(), ""};
  auto attempts = (*spool)->List();
  if (!attempts.ok()) return {"spool", Verdict::kFail, attempts.status().message(), ""};
  size_t waiting = 0, refused = 0;
  std::string because;
  for (const SpooledAttempt& a : *attempts) {
    waiting += !a.complete() && a.refused.empty();
    refused += !a.refused.empty();
    if (because.empty() && a.waits()) because = a.waits_because;
  }
  std::string found = Counted(attempts->size(), "attempt") + ", " + std::to_string(waiting) +
                      " not yet on the server, " + std::to_string(refused) + " refused by it";
  if (!because.empty()) found += " (the last try: " + because + ")";
  if (refused > 0) {
    return {"spool", Verdict::kWarn, found,
            "'enamel-station spool list' says why; when that is resolved: 'enamel-station spool "
            "upload --again ID'"};
  }
  if (waiting == 0) return {"spool", Verdict::kOk, found, ""};
  return {"spool", Verdict::kWarn, found, "enamel-station upload"};
}

// Of the policy that this station keeps. This program may be another one than that which fetched it.
Finding SettingsFromServer(const fs::path& data, const std::set<std::string>& own) {
  std::string taken, left, unknown;
  const protocol::Policy policy = LoadPolicy(data);
  for (const auto& setting : policy.settings()) {
    const Status known = protocol::CheckPolicySetting(setting.name(), setting.value());
    std::string& list = !known.ok()                                        ? unknown
                        : own.contains(setting.name()) && !setting.fixed() ? left
                                                                           : taken;
    list += (list.empty() ? "" : ", ") + setting.name() + " " + setting.value() +
            (setting.fixed() ? " (fixed)" : "");
  }
  std::string found = taken.empty() ? "the server sets none" : "from the server: " + taken;
  if (!left.empty()) found += "; not taken, as this chair sets its own: " + left;
  if (unknown.empty()) return {"settings", Verdict::kOk, found, ""};
  return {"settings", Verdict::kWarn, found + "; not known here, and ignored: " + unknown,
          "update this station"};
}

// On a separate thread, so that the program's other threads keep their priority.
void Realtime(std::vector<Finding>& out) {
  RealtimeGrant grant;
  DurationHistogram late;
  std::thread([&] {
    grant = RequestRealtime();
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    int64_t due = t.tv_sec * kNsPerSecond + t.tv_nsec;
    for (int i = 0; i < kTimerTicks; ++i) {
      due += kTick_ns;
      timespec until{due / kNsPerSecond, due % kNsPerSecond};
      // Only a bare sleep: lateness here is the computer's, not the loop's.
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      clock_gettime(CLOCK_MONOTONIC, &t);
      late.Add(t.tv_sec * kNsPerSecond + t.tv_nsec - due);
    }
  }).join();
  if (grant.refused.empty()) {
    out.push_back({"real-time rights", Verdict::kOk, "priority and memory lock are granted", ""});
  } else {
    out.push_back({"real-time rights", Verdict::kWarn, grant.refused, ""});
  }
  double p99_ms = late.Quantile_ns(0.99) * 1e-6, max_ms = static_cast<double>(late.max_ns()) * 1e-6;
  std::string found = Number(p99_ms, "99 of 100 ticks begin within %.2f ms, ") +
                      Number(max_ms, "the latest %.2f ms late (half a second at 1 kHz)");
  // A tick late by a whole period is flagged in the recording (loop/tick_loop.h).
  bool good = max_ms < 1;
  out.push_back({"timer", good ? Verdict::kOk : Verdict::kWarn, found,
                 good ? "" : "close other programs; real-time rights help most"});
}

Finding DelayFinding(const scene::DelayUsed& delay, std::string found) {
  using From = scene::DelayUsed::From;
  switch (delay.from) {
    case From::kAssumed:
      return {"delay", Verdict::kWarn, std::move(found),
              "or give it a profile that says its delay was measured"};
    case From::kAnswers:
      return {"delay", Verdict::kWarn, std::move(found),
              "close other programs; if it stays, 'enamel-station calibrate' measures all of it"};
    case From::kPoses:
      return {"delay", Verdict::kWarn, std::move(found),
              "plug the device in directly, and set its rate to the loop's where it has one"};
    case From::kProfile:
    case From::kCalibration:
      break;
  }
  return {"delay", Verdict::kOk, std::move(found), ""};
}

// For each device with motors that may be opened: the delay assumed for attempts on it.
void Delays(const fs::path& data, std::vector<Finding>& out) {
  for (const hid::HidInfo& info : hid::ListHid()) {
    if (hid::Recognise(info) != hid::HidKind::kHapticBoard) continue;
    const scene::DelayUsed delay = DelayKnownHere(data, hid::UnitOf(info));
    out.push_back(DelayFinding(delay, DelayText(delay, hid::DeviceNameOf(info))));
  }
  for (const sdk::SdkDevice& found : sdk::ListSdkDevices()) {
    if (found.profile.empty()) continue;  // without its library nothing is known of it
    out.push_back(DelayOf(data, found));
    const std::string asked = sdk::AskedForText(found);
    if (!asked.empty()) out.push_back({"profile", Verdict::kWarn, asked, ""});
  }
}

bool IsSet(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != 0;
}

Finding Graphics() {
  // Such as an ssh session: whether the chair's own screen works stays unknown.
  if (!IsSet("DISPLAY") && !IsSet("WAYLAND_DISPLAY")) {
    return {"graphics", Verdict::kWarn, "not checked, as this session has no display",
            "while the station's window is open, its user checks it with 'DISPLAY=:0 "
            "enamel-station doctor'; --no-graphics leaves it out"};
  }
  try {
    render::ScreenOptions options;
    options.width_px = options.height_px = 64;
    options.visible = false;
    render::Screen screen(options);
    if (!screen.draws_in_software()) return {"graphics", Verdict::kOk, screen.renderer(), ""};
    return {"graphics", Verdict::kWarn, screen.renderer() + ": drawn by the processor",
            "install the graphics card's driver: the picture will be coarse and slow"};
  } catch (const std::exception& error) {
    return {"graphics", Verdict::kFail, error.what(),
            "run this at the station's own screen; --no-graphics leaves it out"};
  }
}

}  // namespace

Finding DevicesOf(const std::vector<hid::HidInfo>& attached,
                  const std::vector<sdk::SdkDevice>& driven) {
  std::string there;
  bool usable = true, has_pedal = false, stands_in = false;
  const auto add = [&](const std::string& device, const Status& problem, bool is_borne) {
    there += (there.empty() ? "" : "; ") + device + (problem.ok() ? "" : ", " + problem.message());
    usable = usable && (problem.ok() || is_borne);
    stands_in = stands_in || is_borne;
  };
  for (const hid::HidInfo& info : attached) {
    if (hid::Recognise(info) == hid::HidKind::kOther) continue;
    Status problem = hid::WhyNotUsable(info);
    if (problem.ok() && hid::Recognise(info) == hid::HidKind::kHapticBoard) {
      problem = hid::AskBoard(info).status();
    }
    has_pedal = has_pedal || (hid::Recognise(info) == hid::HidKind::kFootPedal && problem.ok());
    add(hid::DeviceNameOf(info) + " (" + info.name + ")", problem, false);
  }
  for (const sdk::SdkDevice& found : driven) {
    add((found.ids.empty() ? "" : found.ids + ": ") + found.name + ", driver " + found.choice,
        found.problem, has_pedal && found.problem.field() == trouble::kNoGrip);
  }
  if (!usable) return {"devices", Verdict::kFail, there, ""};
  if (there.empty()) {
    return {"devices", Verdict::kWarn, "none attached: mouse and simulated device are there", ""};
  }
  // The bur stays upright: nobody should learn with that unawares.
  return {"devices", stands_in ? Verdict::kWarn : Verdict::kOk, there, ""};
}

Finding DelayOf(const fs::path& data, const sdk::SdkDevice& device) {
  const auto profile = scene::FindProfile(device.profile);
  if (!profile.ok()) return {"delay", Verdict::kWarn, profile.status().message(), ""};
  std::optional<scene::AnswerTime> answers;
  if (device.answers && device.problem.ok()) {
    hid::DeviceChoice choice;
    choice.device = device.choice;
    choice.thread_setup = [] { (void)RequestRealtime(); };
    auto opened = sdk::OpenChosenDevice(choice, *profile, kTick_ns * 1e-9);
    if (!opened.ok()) return {"delay", Verdict::kWarn, opened.status().message(), ""};
    answers = AwaitAnswerTime(**opened);
  }
  const scene::DelayUsed delay = DelayKnownHere(data, device.unit, *profile, answers);
  return DelayFinding(delay, DelayText(delay, device.name) + ". Profile " + profile->name +
                                 " says " + std::to_string(profile->bus_delay_ticks.value));
}

std::vector<Finding> Examine(const DoctorCommand& options) {
  std::vector<Finding> out;
  Result<Credentials> credentials = Status(Code::kNotFound, "");
  // In the order of setting up a new station: each line assumes those above it.
  out.push_back(Enrolment(options, credentials));
  Server(credentials, out);
  out.push_back(Disk(options.data));
  out.push_back(SpoolState(options.data));
  out.push_back(SettingsFromServer(options.data, options.own_settings));
  Realtime(out);
  out.push_back(DevicesOf(hid::ListHid(), sdk::ListSdkDevices()));
  Delays(options.data, out);
  if (options.graphics) out.push_back(Graphics());
  return out;
}

Status Doctor(const DoctorCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  return program::Report(Examine(options), options.json, "missing for an attempt");
}

}  // namespace enamel::station
