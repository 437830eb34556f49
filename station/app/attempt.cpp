#include "station/app/attempt.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <boost/json.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <thread>

#include "common/base/file.h"
#include "common/scene/json.h"
#include "common/scene/plan.h"
#include "common/scene/volume_blob.h"
#include "station/app/places.h"
#include "station/app/simulate.h"
#include "station/devices/operators.h"
#include "station/loop/realtime.h"
#include "station/render/window.h"
#include "station/spool/recorder.h"
#include "station/uplink/uploader.h"

namespace enamel::station {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr size_t kRingTicks = 4000;  // 4 s at 1 kHz before a slow disk makes a gap
constexpr milliseconds kRecorderIdle{2};
constexpr milliseconds kSpoolRetry{200};
constexpr int kSpoolRetries = 25;
constexpr milliseconds kProgressEvery{200};
constexpr milliseconds kUploadPatience{8'000};  // with the server gone, at the end
constexpr std::chrono::hours kKeepCommitted{7 * 24};

volatile std::sig_atomic_t interrupted = 0;
void OnSignal(int) { interrupted = 1; }

// All of an attempt's documents, fetched and checked; the header lacks its ticket.
struct Job {
  Credentials credentials;
  Person person;
  Sha256 exercise_hash, profile_hash;
  scene::Scene scene;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  cutting::Volume volume;
  trace::Header header;
};

template <typename T>
Status Unknown(const char* what, const std::string& name, const std::vector<T>& known) {
  std::string names;
  for (const T& k : known) names += (names.empty() ? "" : ", ") + k.name;
  return Status(Code::kNotFound,
                std::string("no ") + what + " '" + name + "' for you on this server: " +
                    (names.empty() ? "there are none" : "there are " + names),
                what);
}

template <typename T>
const T* Find(const std::vector<T>& all, const std::string& name) {
  for (const T& one : all) {
    if (one.name == name) return &one;
  }
  return nullptr;
}

Result<Job> Prepare(ServerLink& link, const RunOptions& options) {
  Job job;
  auto credentials = LoadCredentialsFor(options.data, options.server);
  if (!credentials.ok()) return credentials.status();
  job.credentials = *credentials;
  if (Status s = link.Connect(job.credentials); !s.ok()) {
    if (s.code() != Code::kUnavailable) return s;
    return Status(s.code(), s.message() +
                                ". An attempt needs the server to begin; recordings made "
                                "earlier are safe in " +
                                options.data.string() + " ('enamel-station upload' sends them)");
  }
  if (!link.may_begin_attempts()) {
    return Status(Code::kVersion,
                  "the server runs another version of the core: this station can "
                  "upload recordings, not begin attempts; update it");
  }
  auto person = link.SignIn(options.login, options.password);
  if (!person.ok()) return person.status();
  job.person = *person;
  auto catalogue = link.ListExercises(job.person);
  if (!catalogue.ok()) return catalogue.status();
  const auto* exercise = Find(catalogue->exercises, options.exercise);
  if (exercise == nullptr) return Unknown("exercise", options.exercise, catalogue->exercises);
  const auto* profile = Find(catalogue->profiles, options.profile);
  if (profile == nullptr) return Unknown("device profile", options.profile, catalogue->profiles);

  BlobCache cache(options.data / "blobs");
  auto exercise_json = link.FetchBlob(exercise->exercise, cache);
  if (!exercise_json.ok()) return exercise_json.status();
  auto scene_json = link.FetchBlob(exercise->scene, cache);
  if (!scene_json.ok()) return scene_json.status();
  auto profile_json = link.FetchBlob(profile->profile, cache);
  if (!profile_json.ok()) return profile_json.status();
  auto volume_blob = link.FetchBlob(exercise->volume, cache);
  if (!volume_blob.ok()) return volume_blob.status();
  auto parsed_exercise = scene::ExerciseFromJson(AsText(*exercise_json));
  if (!parsed_exercise.ok()) return parsed_exercise.status();
  auto parsed_scene = scene::SceneFromJson(AsText(*scene_json));
  if (!parsed_scene.ok()) return parsed_scene.status();
  auto parsed_profile = scene::ProfileFromJson(AsText(*profile_json));
  if (!parsed_profile.ok()) return parsed_profile.status();
  auto volume = scene::DecodeVolume(*volume_blob);
  if (!volume.ok()) return volume.status();
  job.exercise = std::move(*parsed_exercise);
  job.scene = std::move(*parsed_scene);
  job.profile = std::move(*parsed_profile);
  job.volume = std::move(*volume);

  auto params = scene::CompilePlan(job.scene, job.exercise, job.profile);
  if (!params.ok()) return params.status();
  job.exercise_hash = exercise->exercise;
  job.profile_hash = profile->profile;
  job.header = {{}, exercise->scene, exercise->volume, *params, SoftwareName()};
  return job;
}

// From here on the server waits for this attempt, so everything else is in place before.
Status TakeTicket(ServerLink& link, const RunOptions& options, Job& job) {
  auto ticket = link.RequestTicket(job.credentials, job.person, job.exercise_hash, job.profile_hash,
                                   options.as_reference);
  if (!ticket.ok()) return ticket.status();
  job.header.ticket = *ticket;
  link.Close();
  return Status::Ok();
}

// Feeds the window from the tick.
class WindowFeed final : public TickObserver {
 public:
  WindowFeed(render::Window& window, double voxel_m, uint32_t rate_hz)
      : window_(window), voxel_m_(voxel_m), tick_s_(1.0 / rate_hz) {}

  void OnTick(const core::Core& core, const Snapshot& s) noexcept override {
    render::FrameState frame;
    frame.tick = s.counters.ticks;
    frame.time_s = static_cast<double>(s.counters.ticks + s.counters.gap_ticks) * tick_s_;
    frame.anchor = s.anchor;
    frame.device = s.device;
    frame.force_sent_n = s.force_sent_n;
    frame.bur_on = (s.input_flags & core::kBurOn) != 0;
    if (s.output_flags & haptics::kPeakBounded) frame.warnings |= render::kWarnForceBounded;
    if (s.input_flags & core::kLateTick) frame.warnings |= render::kWarnLate;
    if (s.input_flags & core::kFaulted) frame.warnings |= render::kWarnFault;
    if (s.counters.gap_ticks > 0) frame.warnings |= render::kWarnGap;
    if (s.removed[static_cast<size_t>(cutting::Tissue::kPulp)] > 0) {
      frame.warnings |= render::kWarnPulpExposed;
    }
    frame.removed_mm3 = Removed_mm3(s.removed, voxel_m_);
    window_.Publish(frame);
    window_.PublishBricks(core.volume(), core.touched());
  }

 private:
  render::Window& window_;
  const double voxel_m_;
  const double tick_s_;
};

Result<std::unique_ptr<render::Window>> OpenWindow(const RunOptions& options, const Job& job) {
  render::WindowOptions w;
  w.title = "Enamel";
  w.heading = job.exercise.title + ", " + job.scene.title;
  w.visible = options.window;
  w.bur = job.exercise.bur().metric();
  w.force_full_scale_n = static_cast<double>(job.profile.peak_force_mn.value) * 1e-3;
  w.time_limit_s = job.exercise.time_limit_s;
  return render::Window::Create(w, job.volume);
}

// The recording end of an attempt: ring -> spool -> uplink's attention.
class RecorderThread {
 public:
  RecorderThread(Recorder& recorder, TickLoop& loop, Uploader& uploader)
      : recorder_(recorder), loop_(loop), uploader_(uploader), thread_([this] { Run(); }) {}
  ~RecorderThread() {
    if (thread_.joinable()) thread_.join();
  }
  // After the loop's end. The spool's error when the recording is not complete on disk.
  Result<trace::Seal> Join() {
    thread_.join();
    return std::move(*result_);
  }

 private:
  void Run() {
    int failures = 0;
    while (!result_) {
      bool ended = loop_.finished();  // asked before Pump: nothing comes after it
      uint32_t before = recorder_.chunks();
      auto moved = recorder_.Pump();
      if (!moved.ok()) {
        if (++failures == 1) spdlog::error("{}", moved.status().message());
        if (failures == kSpoolRetries) {
          loop_.RequestStop();
          result_ = moved.status();
        }
        std::this_thread::sleep_for(kSpoolRetry);
        continue;
      }
      failures = 0;
      if (recorder_.chunks() != before) uploader_.Wake();
      if (*moved) continue;
      if (ended)
        result_ = recorder_.Finish();
      else
        std::this_thread::sleep_for(kRecorderIdle);
    }
    uploader_.Wake();
  }

  Recorder& recorder_;
  TickLoop& loop_;
  Uploader& uploader_;
  std::optional<Result<trace::Seal>> result_;
  std::thread thread_;
};

double Sum(const std::array<double, cutting::kTissueCount>& v) {
  double out = 0;
  for (double x : v) out += x;
  return out;
}

// One line that is rewritten on a terminal, a line every few seconds elsewhere.
class Progress {
 public:
  explicit Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) != 0) {}

  void Show(const Snapshot& s, double voxel_m, double done, uint32_t chunks,
            const Uploader::State& up) {
    if (quiet_) return;
    auto now = steady_clock::now();
    if (!terminal_ && now - last_ < std::chrono::seconds(2)) return;
    last_ = now;
    std::fprintf(stderr, "%s%3.0f %%  %llu ticks  removed %.2f mm3  uploaded %u of %u chunks%s%s",
                 terminal_ ? "\r\033[K" : "", 100 * done,
                 static_cast<unsigned long long>(s.counters.ticks),
                 Sum(Removed_mm3(s.removed, voxel_m)), up.committed, chunks,
                 up.reachable ? "" : "  (server not reachable: kept here)", terminal_ ? "" : "\n");
    shown_ = true;
  }
  void End() {
    if (shown_ && terminal_) std::fputc('\n', stderr);
    shown_ = false;
  }

 private:
  const bool quiet_, terminal_;
  bool shown_ = false;
  steady_clock::time_point last_{};
};

Status WriteFacts(const RunOptions& options, const Job& job, const SpooledAttempt& spooled,
                  const Snapshot& last, const AttemptResult& result) {
  auto removed = Removed_mm3(last.removed, job.volume.spec().voxel_m());
  boost::json::object by_tissue;
  for (size_t t = 1; t < removed.size(); ++t) {
    if (removed[t] > 0) by_tissue[std::string(cutting::kTissueNames[t])] = removed[t];
  }
  boost::json::object facts{{"attempt_id", result.attempt.Text()},
                            {"exercise", job.exercise.name},
                            {"profile", job.profile.name},
                            {"operator", options.operator_name},
                            {"ticks", spooled.ticks},
                            {"gap_ticks", spooled.gap_ticks},
                            {"late_ticks", last.counters.late_ticks},
                            {"bounded_ticks", last.counters.bounded_ticks},
                            {"faults", last.counters.faults},
                            {"chunks", spooled.chunks},
                            {"committed_chunks", spooled.committed},
                            {"trace_bytes", spooled.bytes},
                            {"removed_mm3", by_tissue},
                            {"uploaded", result.uploaded},
                            {"ended_early", result.ended_early},
                            {"problem", result.not_uploaded_because}};
  return WriteFileDurably(options.json, AsBytes(boost::json::serialize(facts) + "\n"));
}

// The window of an attempt, when it has one.
struct Screen {
  std::unique_ptr<render::Window> window;
  std::optional<WindowFeed> feed;
  TickObserver* observer() { return feed ? &*feed : nullptr; }
};

Status OpenScreen(const RunOptions& options, const Job& job, Screen& screen) {
  if (!options.window && options.screenshot.empty()) return Status::Ok();
  auto window = OpenWindow(options, job);
  if (!window.ok()) return window.status();
  screen.window = std::move(*window);
  screen.feed.emplace(*screen.window, job.volume.spec().voxel_m(), job.header.params.rate_hz);
  return Status::Ok();
}

// Everything that runs during one attempt, in the order it must be destroyed in reverse.
class Session {
 public:
  Session(const RunOptions& options, Job& job, Spool& spool, SimulatedDevice& device,
          Screen& screen)
      : options_(options),
        job_(job),
        spool_(spool),
        device_(device),
        screen_(screen),
        core_(job.header.params, job.volume),
        ring_(kRingTicks),
        recorder_(spool, ring_, job.header.ticket.attempt,
                  HashSha256(trace::EncodeHeader(job.header)), job.credentials.secret_key),
        progress_(options.quiet) {}

  Result<AttemptResult> Run() {
    const Uuid attempt = job_.header.ticket.attempt;
    ENAMEL_RETURN_IF_ERROR(spool_.BeginAttempt(job_.header, job_.exercise.name, job_.profile.name));
    // A simulated device's time is the loop's own: being late harms nobody.
    TickLoop loop(device_, core_, ring_, {job_.header.params.rate_hz, options_.lockstep, false},
                  screen_.observer());
    Uploader uploader(job_.credentials, spool_, attempt);
    std::thread ticks([&] {
      if (!options_.lockstep) {
        RealtimeGrant grant = RequestRealtime();
        if (!grant.refused.empty()) spdlog::warn("{}", grant.refused);
      }
      loop.Run();
    });
    Result<trace::Seal> seal = Status(Code::kInternal, "the recorder did not run");
    {
      RecorderThread recorder(recorder_, loop, uploader);
      Watch(loop, uploader);
      ticks.join();
      seal = recorder.Join();
    }
    last_ = loop.snapshot();
    Status picture = TakePicture();
    if (!seal.ok()) return seal.status();
    AttemptResult result;
    result.attempt = attempt;
    result.ended_early = ended_early_;
    result.done_ratio = device_.progress();
    AwaitUpload(uploader, result);
    progress_.End();
    ENAMEL_RETURN_IF_ERROR(picture);
    auto spooled = spool_.Get(attempt);
    if (!spooled.ok()) return spooled.status();
    if (!options_.json.empty()) {
      ENAMEL_RETURN_IF_ERROR(WriteFacts(options_, job_, *spooled, last_, result));
    }
    return result;
  }

 private:
  double voxel_m() const { return job_.volume.spec().voxel_m(); }

  void Watch(TickLoop& loop, Uploader& uploader) {
    auto next = steady_clock::now();
    auto over = [&] {
      if (interrupted) EndEarly(loop);
      if (steady_clock::now() >= next) {
        next = steady_clock::now() + kProgressEvery;
        progress_.Show(loop.snapshot(), voxel_m(), device_.progress(), recorder_.chunks(),
                       uploader.state());
      }
      return loop.finished();
    };
    if (screen_.window) {
      screen_.window->Run(over);
      EndEarly(loop);  // unless it has ended: the operator closed the window
    }
    while (!over()) std::this_thread::sleep_for(milliseconds(20));
  }

  void EndEarly(TickLoop& loop) {
    if (loop.finished()) return;
    ended_early_ = true;
    loop.RequestStop();
  }

  Status TakePicture() {
    if (screen_.window && !options_.screenshot.empty()) {
      screen_.window->FlushBricks(core_.volume());
      return screen_.window->WriteScreenshot(options_.screenshot.string());
    }
    return Status::Ok();
  }

  void AwaitUpload(Uploader& uploader, AttemptResult& result) {
    uploader.Wake();
    std::atomic<bool> done{false};
    std::thread shower([&] {
      while (!done) {
        progress_.Show(last_, voxel_m(), 1, recorder_.chunks(), uploader.state());
        std::this_thread::sleep_for(milliseconds(50));
      }
    });
    uploader.WaitUntilDone(kUploadPatience);
    done = true;
    shower.join();
    uploader.Stop();
    Uploader::State state = uploader.state();
    result.uploaded = state.sealed;
    if (!state.sealed) result.not_uploaded_because = state.problem.message();
  }

  const RunOptions& options_;
  Job& job_;
  Spool& spool_;
  SimulatedDevice& device_;
  Screen& screen_;
  core::Core core_;
  SampleRing ring_;
  Recorder recorder_;
  Progress progress_;
  Snapshot last_;
  bool ended_early_ = false;
};

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
  ENAMEL_RETURN_IF_ERROR(CheckOutputFile(options.json, "--json"));
  ENAMEL_RETURN_IF_ERROR(CheckOutputFile(options.screenshot, "--screenshot"));
  ServerLink link;
  auto job = Prepare(link, options);
  if (!job.ok()) return job.status();
  auto spool = Spool::Open(options.data);
  if (!spool.ok()) return spool.status();
  if (auto pruned = (*spool)->Prune(kKeepCommitted); !pruned.ok()) return pruned.status();
  auto device = MakeSimulatedDevice(*preset, job->scene, job->exercise, job->profile,
                                    job->header.params, job->volume, options.seed);
  if (!device.ok()) return device.status();
  Screen screen;
  ENAMEL_RETURN_IF_ERROR(OpenScreen(options, *job, screen));
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  ENAMEL_RETURN_IF_ERROR(TakeTicket(link, options, *job));
  Session session(options, *job, **spool, **device, screen);
  return session.Run();
}

}  // namespace enamel::station
