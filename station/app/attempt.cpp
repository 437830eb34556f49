#include "station/app/attempt.h"

#include <termios.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <thread>

#include "common/base/utf8.h"
#include "common/program/output.h"
#include "common/scene/tooth_number.h"
#include "station/app/simulate.h"
#include "station/desk/watch/tick_feed.h"
#include "station/devices/operators.h"
#include "station/loop/realtime.h"
#include "station/render/display_watch.h"
#include "station/render/window.h"
#include "station/sdk/open_sdk_device.h"
#include "station/session/by_name.h"
#include "station/session/device_delay.h"
#include "station/session/stop_signals.h"

namespace enamel::station {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kProgressEvery{200};
constexpr milliseconds kUploadPatience{8'000};     // with the server gone, at the end
constexpr milliseconds kSameInterrupt{2'000};      // Enter and then Ctrl-C means to finish
constexpr milliseconds kLeavePatience{2'000};      // for the last chunks of an attempt that is left
constexpr std::chrono::seconds kDiskPatience{60};  // with a disk that takes nothing

// Id of the interrupted attempt that `text` names.
Result<Uuid> Unfinished(Workplace& workplace, const std::string& text) {
  if (text != "last") return Uuid::Parse(text);
  ENAMEL_ASSIGN_OR_RETURN(auto all, workplace.Unfinished());
  if (!all.empty()) return all.back().id;
  return Status(Code::kNotFound, "no attempt was cut off here: there is nothing to resume");
}

Result<PreparedAttempt> PrepareResume(Workplace& workplace, const RunOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Unfinished(workplace, options.resume));
  // Begun on a reserved ticket: its PIN proves the person, with or without the server.
  if (!options.pin.empty()) return workplace.PrepareResume(id, options.pin);
  ENAMEL_ASSIGN_OR_RETURN(auto person, workplace.SignIn(options.login, options.password));
  return workplace.PrepareResume(id);
}

// Prepares the attempt, with its ticket if it has one already.
Result<PreparedAttempt> Prepare(Workplace& workplace, const RunOptions& options) {
  if (!options.resume.empty()) return PrepareResume(workplace, options);
  if (!options.reserved.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(options.reserved));
    return workplace.PrepareReserved(id, options.pin);
  }
  ENAMEL_ASSIGN_OR_RETURN(auto person, workplace.SignIn(options.login, options.password));
  WantedExercise wanted{options.exercise, {}, {}};
  // A device identifies itself when it is opened.
  if (options.device.device.empty()) {
    wanted.hand =
        MakeHand(HandKind::kProgram, "simulated device", "operator " + options.operator_name);
  }
  if (!options.assignment.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(wanted.assignment, Uuid::Parse(options.assignment));
  }
  return PrepareByName(workplace, wanted, options.profile);
}

Result<std::unique_ptr<render::Window>> OpenWindow(const RunOptions& options,
                                                   const PreparedAttempt& job) {
  render::WindowOptions w;
  w.heading = job.exercise.title + ", " + job.scene.title;
  w.screen.visible = options.window;
  w.view.burs = core::BursOf(job.header.params);
  w.view.mesial_x = scene::MesialX(job.scene.tooth);
  // The bar is full at the device's peak force, so that it means the same in every exercise.
  w.view.force_full_scale_n = static_cast<double>(job.profile.peak_force_mn.value) * 1e-3;
  w.time_limit_s = job.exercise.time_limit_s;
  w.uncut = &job.volume;
  // Resumed: the tooth as already cut.
  return render::Window::Create(w, job.core ? job.core->volume() : job.volume);
}

double Sum(const std::array<double, cutting::kTissueCount>& v) {
  double out = 0;
  for (double x : v) out += x;
  return out;
}

// One line that is rewritten on a terminal, a line every few seconds elsewhere. The cursor stays at
// its beginning, so that a line of the log, which is longer, replaces it.
class Progress {
 public:
  Progress(bool quiet, bool log_only)
      : quiet_(quiet || log_only), log_only_(log_only), terminal_(::isatty(STDERR_FILENO) != 0) {}

  void Show(const Snapshot& s, double voxel_m, double done, uint32_t chunks,
            const Uploader::State& up) {
    if (quiet_) return;
    auto now = steady_clock::now();
    // In a file every line stays: one in two seconds is enough to show progress.
    if (!terminal_ && now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(
        stderr, "%s%3.0f %%  %llu ticks  removed %.2f mm3  uploaded %u of %u chunks%s%s",
        terminal_ ? "\r\033[K" : "", 100 * done, static_cast<unsigned long long>(s.counters.ticks),
        Sum(Removed_mm3(s.removed, voxel_m)), up.committed, chunks,
        up.reachable ? "" : "  (server not reachable: kept here)", terminal_ ? "\r" : "\n");
    shown_ = true;
  }
  void End() {
    if (shown_ && terminal_) std::fputc('\n', stderr);
    shown_ = false;
  }
  // A separate line, even when quiet: why there is no force, and what to do.
  void Tell(const Snapshot& s) {
    const std::string why = s.fault != Fault::kNone ? FaultText(s.fault)
                            : s.put_down ? "the handpiece is in its holder: take it out to continue"
                                         : "";
    // Once for each change: a fault lasts for many ticks.
    if (why == told_ || log_only_) return;
    told_ = why;
    End();
    std::fprintf(stderr, "%s%s\n",
                 why.empty() ? "force comes on again in free air" : "force is off: ", why.c_str());
  }

  // A separate line, even when quiet: a message to the person at the chair.
  void Say(const std::string& line) {
    End();
    std::fprintf(stderr, "%s\n", line.c_str());
  }

 private:
  const bool quiet_, log_only_, terminal_;
  bool shown_ = false;
  std::string told_;
  steady_clock::time_point last_{};
};

// The attempt's delay in ticks and its source: "profile", "calibration", "assumed", "answers",
// "poses", or "construction" for a device that is not attached.
boost::json::object DelayFacts(const PreparedAttempt& job) {
  if (!job.delay) {
    return {{"ticks", job.profile.bus_delay_ticks.value}, {"from", "construction"}};
  }
  using From = scene::DelayUsed::From;
  const char* from = job.delay->from == From::kProfile       ? "profile"
                     : job.delay->from == From::kCalibration ? "calibration"
                     : job.delay->from == From::kAnswers     ? "answers"
                     : job.delay->from == From::kPoses       ? "poses"
                                                             : "assumed";
  return {{"ticks", job.delay->ticks}, {"from", from}};
}

Status WriteFacts(const RunOptions& options, const PreparedAttempt& job,
                  const SpooledAttempt& spooled, const Snapshot& last, const AttemptResult& result,
                  const boost::json::object& loop) {
  auto removed = Removed_mm3(last.removed, job.volume.spec().voxel_m());
  boost::json::object by_tissue;
  for (size_t t = 1; t < removed.size(); ++t) {
    if (removed[t] > 0) by_tissue[std::string(cutting::kTissueNames[t])] = removed[t];
  }
  boost::json::object facts{
      {"attempt_id", result.attempt.Text()},
      {"exercise", job.exercise.name},
      {"profile", job.profile.name},
      {"kc_mn_per_mm", job.header.params.kc_mn_per_mm},
      {"delay", DelayFacts(job)},
      {"operator", options.device.device.empty() ? options.operator_name : ""},
      {"ticks", spooled.ticks},
      {"gap_ticks", spooled.gap_ticks},
      {"late_ticks", last.counters.late_ticks},
      {"bounded_ticks", last.counters.bounded_ticks},
      {"faults", last.counters.faults},
      {"loop", loop},
      {"chunks", spooled.chunks},
      {"committed_chunks", spooled.committed},
      {"trace_bytes", spooled.bytes},
      {"removed_mm3", by_tissue},
      {"uploaded", result.uploaded},
      {"left", result.left},
      {"problem", result.not_uploaded_because}};
  const boost::json::value said = boost::json::parse(protocol::FactsJson(spooled.facts));
  facts.insert(said.as_object().begin(), said.as_object().end());
  return program::WriteJsonFile(options.json, facts);
}

// The attempt's device, and again as simulated device if it is one.
struct Tool {
  std::unique_ptr<Device> device;
  SimulatedDevice* simulated = nullptr;
  // Only a simulated operator knows its progress.
  double progress() const { return simulated != nullptr ? simulated->progress() : 0; }
};

Result<Tool> OpenTool(const RunOptions& options, PreparedAttempt& job) {
  Tool out;
  if (options.device.device.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(
        auto made,
        MakeSimulatedDevice(*FindOperator(options.operator_name), job.scene, job.exercise,
                            job.profile, job.header.params, job.volume, options.seed));
    out.simulated = made.get();
    out.device = std::move(made);
    ENAMEL_RETURN_IF_ERROR(UseHandOf(job, *out.device));
    return out;
  }
  if (options.lockstep) {
    return Status(Code::kInvalidInput,
                  "--lockstep is for the simulated device: a real one's time is the clock's",
                  "lockstep");
  }
  hid::DeviceChoice choice = options.device;
  // A board's reader has to wake as punctually as the loop that reads from it. The loop's own
  // request reports a refusal.
  choice.thread_setup = [] { (void)RequestRealtime(); };
  ENAMEL_ASSIGN_OR_RETURN(
      auto opened, sdk::OpenChosenDevice(choice, job.profile, 1.0 / job.header.params.rate_hz));
  out.device = std::move(opened);
  // Before the ticket: the signed header contains the delay, and hence the coupling.
  ENAMEL_RETURN_IF_ERROR(
      UseDelayOf(job, *out.device, AwaitPace(*out.device), options.workplace.data));
  ENAMEL_RETURN_IF_ERROR(UseHandOf(job, *out.device));
  return out;
}

// The window of an attempt, if it has one.
struct Screen {
  std::unique_ptr<render::Window> window;
  std::optional<desk::TickFeed> feed;
  TickObserver* observer() { return feed ? &*feed : nullptr; }
};

Status OpenScreen(const RunOptions& options, const PreparedAttempt& job, Screen& screen) {
  if (!options.window) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto window, OpenWindow(options, job));
  screen.window = std::move(window);
  screen.feed.emplace(screen.window->tooth(), job.volume.spec().voxel_m(),
                      job.header.params.rate_hz);
  return Status::Ok();
}

// Shows a running attempt, and ends it on request.
class Watcher {
 public:
  Watcher(const RunOptions& options, RunningAttempt& attempt, const PreparedAttempt& job,
          Tool& tool, Screen& screen, Workplace& workplace)
      : options_(options),
        attempt_(attempt),
        job_(job),
        tool_(tool),
        screen_(screen),
        workplace_(workplace),
        progress_(options.quiet, options.log_only) {}

  Result<AttemptResult> Run() {
    Watch();
    // In every case: the recorder has to store the rest before anything returns.
    const Status recorded = attempt_.left() ? attempt_.Leave() : attempt_.Join().status();
    last_ = attempt_.snapshot();
    ENAMEL_RETURN_IF_ERROR(recorded);
    AttemptResult result;
    result.attempt = attempt_.attempt();
    result.left = attempt_.left();
    if (result.left) {
      SendWhatIsLeft();
    } else {
      SignEnd();
      AwaitUpload(result);
    }
    progress_.End();
    ENAMEL_ASSIGN_OR_RETURN(auto spooled, workplace_.spool().Get(result.attempt));
    result.refused = spooled.refused;
    if (!options_.json.empty()) {
      ENAMEL_RETURN_IF_ERROR(WriteFacts(options_, job_, spooled, last_, result, attempt_.facts()));
    }
    return result;
  }

 private:
  void Watch() {
    auto next = steady_clock::now();
    auto over = [&] {
      if (StopsAsked() > 0) Leave();
      if (options_.finish && options_.finish()) attempt_.End();
      WatchDisk();
      if (steady_clock::now() >= next) {
        next = steady_clock::now() + kProgressEvery;
        Show(attempt_.snapshot(), tool_.progress());
      }
      return attempt_.recorded();
    };
    if (screen_.window) {
      // On this thread, because window systems require their events on the thread that made the
      // window.
      const render::DisplayWatch display([this] {
        (void)attempt_.Leave();
        tool_.device.reset();  // with its last force, 0: the process ends here
      });
      screen_.window->Run(over);
      Leave();  // unless it has ended: the operator closed the window
    }
    // Without a window only waiting remains; the loop has its own threads.
    while (!over()) std::this_thread::sleep_for(milliseconds(20));
  }

  // Waits for a full disk, but not for ever: nobody may be there to make room.
  void WatchDisk() {
    auto now = steady_clock::now();
    if (attempt_.recording().problem.ok()) {
      disk_fails_since_.reset();
      return;
    }
    if (!disk_fails_since_) disk_fails_since_ = now;
    if (now - *disk_fails_since_ < kDiskPatience) return;
    attempt_.End();
    // The stored part stays and can be closed or resumed later; the rest is lost.
    attempt_.GiveUp();
  }

  // Prints messages to this chair. Where output goes only to a log nobody reads it here, so they do
  // not count as shown.
  void TellRemarks() {
    while (auto remark = options_.log_only ? std::nullopt : attempt_.remark()) {
      progress_.Say(remark->from + " says: " + remark->text);
      attempt_.RemarkShown(remark->id);
    }
  }

  void Show(const Snapshot& snapshot, double done) {
    TellRemarks();
    progress_.Tell(snapshot);
    progress_.Show(snapshot, job_.voxel_m(), done, attempt_.recording().chunks, attempt_.upload());
  }

  void Leave() {
    if (!attempt_.recorded()) (void)attempt_.Leave();
  }

  // Not signed is no error: the attempt counts, and its reviewers see it.
  void SignEnd() {
    if (!job_.terms.sign_off) return;
    const uint32_t chunks = attempt_.recording().chunks;
    // What the server does not have yet cannot be signed there.
    (void)AwaitServer([&](const Uploader::State& state) { return state.committed >= chunks; });
    auto signer = workplace_.SignOff(attempt_.attempt(), SignedAt::kEnd, options_.signer,
                                     options_.signer_pin);
    if (!signer.ok()) {
      progress_.Say("the end of this attempt is not signed: " + signer.status().message());
    }
    workplace_.HandIn(attempt_.attempt());
  }

  // The server, if it is there, then has all of it. A chair that resumes it needs none of this.
  void SendWhatIsLeft() {
    const auto until = steady_clock::now() + kLeavePatience;
    const uint32_t chunks = attempt_.recording().chunks;
    while (attempt_.upload().reachable && attempt_.upload().committed < chunks &&
           steady_clock::now() < until) {
      std::this_thread::sleep_for(milliseconds(20));
    }
  }

  // Waits until `done`, or the attempt is refused, the server is away for some time, or another
  // wish to stop comes, which returns true.
  bool AwaitServer(const std::function<bool(const Uploader::State&)>& done) {
    int asked_before = StopsAsked();
    const auto since = steady_clock::now();
    auto reachable_at = since;
    Uploader::State state = attempt_.upload();
    auto waits = [&] {
      auto now = steady_clock::now();
      if (state.reachable) reachable_at = now;
      // Somebody who has just finished does not mean to end the upload too.
      if (now - since < kSameInterrupt) asked_before = StopsAsked();
      return !done(state) && !state.gave_up && StopsAsked() == asked_before &&
             now - reachable_at < kUploadPatience;
    };
    for (; waits(); state = attempt_.upload()) {
      Show(last_, 1);
      std::this_thread::sleep_for(milliseconds(20));
    }
    Show(last_, 1);
    return StopsAsked() != asked_before;
  }

  void AwaitUpload(AttemptResult& result) {
    const bool stopped = AwaitServer([](const Uploader::State& state) { return state.sealed; });
    const Uploader::State state = attempt_.upload();
    result.uploaded = state.sealed;
    if (state.sealed) return;
    result.not_uploaded_because =
        stopped ? "interrupted while it was being sent" : state.problem.message();
  }

  const RunOptions& options_;
  RunningAttempt& attempt_;
  const PreparedAttempt& job_;
  Tool& tool_;
  Screen& screen_;
  Workplace& workplace_;
  Progress progress_;
  Snapshot last_;
  std::optional<steady_clock::time_point> disk_fails_since_;
};

// "12.3 s", "8 min".
std::string SpanText(double seconds) {
  char text[32];
  if (seconds < 120)
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  else
    std::snprintf(text, sizeof text, "%.0f min", seconds / 60);
  return text;
}

void SayResumed(const RunOptions& options, const PreparedAttempt& job) {
  if (options.quiet || options.log_only) return;
  const double rate = job.header.params.rate_hz;
  std::fprintf(stderr,
               "resuming '%s': the %s recorded before the interruption were replayed tick by tick; "
               "the %s since then count as a gap. Force comes on once the bur has been in free "
               "air\n",
               Printable(job.exercise.title).c_str(),
               SpanText(static_cast<double>(job.place.next_tick) / rate).c_str(),
               SpanText(job.gap_ticks / rate).c_str());
}

// A refused signature hands the ticket back (Workplace), so that it does not count.
Status SignStart(Workplace& workplace, const RunOptions& options, const PreparedAttempt& job) {
  if (!options.signer.empty()) {
    return workplace.SignOff(job.attempt(), SignedAt::kStart, options.signer, options.signer_pin)
        .status();
  }
  return Status(Code::kInvalidInput,
                "this exam needs the signature of an instructor at the chair: --signer LOGIN, with "
                "the PIN in ENAMEL_SIGNER_PIN",
                "signer");
}

}  // namespace

Result<AttemptResult> RunAttempt(const RunOptions& options) {
  const OperatorPreset* preset = FindOperator(options.operator_name);
  if (preset == nullptr) {
    std::vector<OperatorPreset> all(OperatorPresets().begin(), OperatorPresets().end());
    std::string names;
    for (const auto& p : all) names += (names.empty() ? "" : ", ") + std::string(p.name);
    return Status(Code::kNotFound,
                  "no simulated operator '" + options.operator_name + "': there are " + names,
                  "operator");
  }
  // Before a ticket is used: an attempt must not be lost over a file name.
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(auto workplace, Workplace::Open(options.workplace));
  ENAMEL_ASSIGN_OR_RETURN(auto job, Prepare(*workplace, options));
  job.facts = options.facts;
  ENAMEL_ASSIGN_OR_RETURN(auto tool, OpenTool(options, job));
  Screen screen;
  ENAMEL_RETURN_IF_ERROR(OpenScreen(options, job, screen));
  CatchStopSignals();
  // Last of all that can fail: a ticket counts as an attempt once taken.
  if (job.attempt().IsZero()) {
    ENAMEL_RETURN_IF_ERROR(workplace->TakeTicket(job, options.as_reference));
    if (job.terms.sign_off) ENAMEL_RETURN_IF_ERROR(SignStart(*workplace, options, job));
  }
  if (job.core) {
    SayResumed(options, job);
  }
  workplace->SignOut();  // uploading needs no sign-in
  if (StopsAsked() > 0) {
    return Status(Code::kUnavailable, "stopped before the first tick: no attempt is used up");
  }
  // A line that was typed while the device was opened is no wish to finish.
  if (options.finish) ::tcflush(STDIN_FILENO, TCIFLUSH);
  // A simulated device's time is the loop's own: lateness harms nobody.
  ENAMEL_ASSIGN_OR_RETURN(auto attempt,
                          workplace->Begin(job, *tool.device,
                                           {options.lockstep, tool.simulated == nullptr,
                                            screen.observer(), options.cpu}));
  return Watcher(options, *attempt, job, tool, screen, *workplace).Run();
}

}  // namespace enamel::station
