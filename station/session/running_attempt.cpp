#include "station/session/running_attempt.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>

#include "common/base/unix_time.h"
#include "station/loop/realtime.h"
#include "station/session/loop_facts.h"

namespace enamel::station {
namespace {

using std::chrono::milliseconds;

constexpr size_t kRingTicks = 4000;  // 4 s at 1 kHz before a slow disk makes a gap
// Between two looks into the ring: a fraction of a chunk's time, and few wake-ups.
constexpr milliseconds kRecorderIdle{2};
constexpr milliseconds kSpoolRetry{200};
// As often as a page can draw.
constexpr uint32_t kLivePerSecond = 60;
constexpr double kUmPerM = 1e6, kMnPerN = 1e3;

trace::ChainState PlaceOf(const PreparedAttempt& prepared) {
  // Chunk 0 names the header's hash as its predecessor.
  if (prepared.place.next_seq > 0) return prepared.place;
  return {HashSha256(trace::EncodeHeader(prepared.header)), 0, 0, 0};
}

}  // namespace

TickLoopOptions LoopOptionsOf(const PreparedAttempt& prepared, const AttemptOptions& options) {
  TickLoopOptions out;
  out.rate_hz = prepared.header.params.rate_hz;
  out.lockstep = options.lockstep;
  out.faults_when_late = options.faults_when_late;
  out.damping_n_s_per_m = static_cast<double>(prepared.profile.viscous_mn_s_per_m()) * 1e-3;
  if (const auto& torque = prepared.profile.torque) {
    out.rotational_damping_n_m_s = static_cast<double>(torque->damping_un_m_s_per_rad.value) * 1e-6;
  }
  out.ticks_before = prepared.place.next_tick;
  out.first_gap_ticks = prepared.gap_ticks;
  out.stops_asked = options.stops_asked;
  return out;
}

namespace {

// The bound holds for every point of a scene.
std::array<int32_t, 3> Rounded(const dvec3& v, double scale) noexcept {
  std::array<int32_t, 3> out{};
  for (int i = 0; i < 3; ++i) {
    double x = std::clamp(v[i] * scale, -1e9, 1e9);
    out[static_cast<size_t>(i)] = static_cast<int32_t>(x);
  }
  return out;
}

}  // namespace

RunningAttempt::RunningAttempt(const trace::SecretKey& station_key, Spool& spool,
                               Uploader& uploader, PreparedAttempt& prepared, Device& device,
                               const AttemptOptions& options, RecordingLock lock)
    : lock_(std::move(lock)),
      attempt_(prepared.attempt()),
      spool_(spool),
      device_(device),
      uploader_(uploader),
      observer_(options.observer),
      rate_hz_(prepared.header.params.rate_hz),
      live_every_(std::max(1u, rate_hz_ / kLivePerSecond)),
      core_(prepared.core ? std::move(prepared.core)
                          : std::make_unique<core::Core>(prepared.header.params, prepared.volume)),
      ring_(kRingTicks),
      recorder_(spool, ring_, attempt_, PlaceOf(prepared), station_key,
                Recorder::TicksPerChunk(rate_hz_)),
      loop_(device, *core_, ring_, LoopOptionsOf(prepared, options), this) {
  // Before the first tick: everything the threads use is ready, and the uploader expects the
  // chunks.
  uploader_.Prefer(attempt_, live_);
  recorder_thread_ = std::thread([this] { Record(); });
  loop_thread_ = std::thread([this, options] { RunLoop(options); });
}

RunningAttempt::~RunningAttempt() { (void)Leave(); }

void RunningAttempt::End() {
  ended_ = true;
  loop_.RequestStop();
}

Status RunningAttempt::Leave() {
  if (!ended_ && ticking()) left_ = true;
  loop_.RequestStop();
  // Without this the recorder would wait for a full disk for ever: nobody is left to free space.
  GiveUp();
  AwaitThreads();
  // Its seal, if somebody closes it later, is for no one to sign here.
  if (left()) uploader_.ReleaseSeal(attempt_);
  return *recorded_;
}

void RunningAttempt::OnTick(const core::Core& core, const Snapshot& snapshot) noexcept {
  if (snapshot.counters.ticks % live_every_ == 0) {
    const dvec3 origin_m = core.TipOf({});
    live_->Write({snapshot.counters.ticks, Rounded(snapshot.anchor.tip_m - origin_m, kUmPerM),
                  Rounded(snapshot.pressed_n, kMnPerN), snapshot.output_flags});
  }
  if (observer_ != nullptr) observer_->OnTick(core, snapshot);
}

void RunningAttempt::RunLoop(const AttemptOptions& options) {
  if (!options.lockstep) {
    RealtimeGrant grant = RequestRealtime({options.cpu});
    lacks_realtime_ = !grant.steady();
    // Lateness is harmless without motors and in simulations.
    auto level = options.faults_when_late ? spdlog::level::warn : spdlog::level::info;
    if (!grant.refused.empty()) spdlog::log(level, "{}", grant.refused);
  }
  loop_.Run();
}

void RunningAttempt::Record() {
  while (!(recorded_ = RecordOnce())) LogFaults();
  // The facts are the loop's own numbers, which are final only once it has ended.
  while (!loop_.finished()) std::this_thread::sleep_for(kRecorderIdle);
  LogFaults();
  KeepFacts();
  LogEnd(*recorded_);
  done_ = true;
  uploader_.Wake();
}

// After the loop's end and the last sample.
Status RunningAttempt::Close() {
  if (left()) return recorder_.Flush();
  auto seal = recorder_.Finish();
  if (seal.ok()) seal_ = *seal;
  return seal.status();
}

// One turn of the recorder; returns the outcome if that was the last.
std::optional<Status> RunningAttempt::RecordOnce() {
  // Read before Pump: nothing comes after the end, and one try follows GiveUp.
  const bool ended = loop_.finished(), last_try = ended && give_up_;
  const uint32_t before = recorder_.chunks();
  auto moved = recorder_.Pump();
  std::optional<Status> closed;
  if (moved.ok() && !*moved && ended) closed = Close();
  // After each chunk, not each tick: chunks are what is sent.
  if (recorder_.chunks() != before) uploader_.Wake();
  const Status status = closed ? *closed : moved.status();
  const bool try_again = status.code() == Code::kStorage;
  Note(status);
  // Not the disk: the spool reports another recording, or an older program runs. Waiting does not
  // help, and further ticks would only be lost.
  if (!status.ok() && !try_again) {
    loop_.RequestStop();
    return status;
  }
  if (try_again && last_try) return Lost(status);
  if (closed && status.ok()) return status;
  if (try_again)
    std::this_thread::sleep_for(kSpoolRetry);
  else if (!*moved)
    std::this_thread::sleep_for(kRecorderIdle);
  return std::nullopt;
}

// Not worth an attempt: if the disk takes the recording but not these, they are lost.
void RunningAttempt::KeepFacts() {
  auto stored = spool_.Get(attempt_);
  Status kept = stored.ok() ? spool_.loop_facts().Put(attempt_, {stored->facts.resumed(), UnixMs(),
                                                                 boost::json::serialize(facts())})
                            : stored.status();
  if (!kept.ok()) {
    spdlog::warn("how the loop of attempt {} went is not kept: {}", attempt_.Text(),
                 kept.message());
  }
}

void RunningAttempt::LogFaults() {
  const Fault now = loop_.fault();
  if (now == logged_) return;
  if (now != Fault::kNone) {
    const Status device = device_.problem();
    spdlog::warn("attempt {}: the force is off: {}{}", attempt_.Text(), FaultText(now),
                 device.ok() ? "" : " (" + device.message() + ")");
  } else {
    spdlog::info("attempt {}: the force comes on again, in free air", attempt_.Text());
  }
  logged_ = now;
}

void RunningAttempt::LogEnd(const Status& status) const {
  const DurationHistogram& late = loop_.lateness();
  const std::string how = fmt::format(
      "{}; 99 of 100 ticks at most {:.0f} us late, the latest {:.0f} us; {} chunks stored here",
      CountsText(loop_.counters()), late.Quantile_ns(0.99) * 1e-3,
      static_cast<double>(late.max_ns()) * 1e-3, recorder_.chunks());
  if (status.ok()) {
    spdlog::info("attempt {} {}: {}", attempt_.Text(),
                 left() ? "is left and can be resumed" : "has ended", how);
  } else {
    spdlog::error("attempt {} has ended and is not whole: {}: {}", attempt_.Text(), how,
                  status.message());
  }
}

// Ticks that cannot be recorded are not felt.
void RunningAttempt::Note(const Status& problem) {
  loop_.Hold(!problem.ok());
  MutexLock lock(mutex_);
  if (problem_.ok() && !problem.ok()) {
    spdlog::error(
        "{}. Until then there is no force and no cut; the last {:.2f} s are kept in memory and "
        "tried again",
        problem.message(), static_cast<double>(recorder_.waiting_ticks()) / rate_hz_);
  } else if (!problem_.ok() && problem.ok()) {
    spdlog::info("attempt {} is recorded again: nothing of it was lost", attempt_.Text());
  }
  problem_ = problem;
}

Status RunningAttempt::Lost(const Status& why) const {
  auto span_s = [&](uint64_t ticks) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f s", static_cast<double>(ticks) / rate_hz_);
    return std::string(text);
  };
  // Reported here, where both numbers are known: how much is safe, how much is not, and what to do.
  const std::string id = attempt_.Text();
  if (recorder_.chunks() == 0) {
    return Status(why.code(), why.message() + ". Of attempt " + id + " nothing could be stored");
  }
  return Status(why.code(),
                why.message() + ". Of attempt " + id + " the first " + span_s(recorder_.ticks()) +
                    " are safe in the spool, the last " + span_s(recorder_.waiting_ticks()) +
                    " could not be stored and are lost. It has no end yet: 'enamel-station run "
                    "--resume " +
                    id + "' resumes it, 'enamel-station spool close " + id +
                    "' ends it where it stopped");
}

RunningAttempt::Recording RunningAttempt::recording() const {
  MutexLock lock(mutex_);
  return {recorder_.chunks(), recorder_.ticks(), recorder_.waiting_ticks(), problem_};
}

void RunningAttempt::AwaitThreads() {
  // A window that is closed leaves an attempt whose end its task awaits.
  MutexLock alone(joining_);
  if (loop_thread_.joinable()) loop_thread_.join();
  if (recorder_thread_.joinable()) recorder_thread_.join();
  // Both threads have ended: another process may record here now.
  lock_.reset();
}

Result<trace::Seal> RunningAttempt::Join() {
  AwaitThreads();
  if (!recorded_->ok()) return *recorded_;
  ENAMEL_CHECK(seal_.has_value());
  return *seal_;
}

boost::json::object RunningAttempt::facts() const { return LoopFacts(loop_, device_); }

Uploader::State RunningAttempt::AwaitUpload(milliseconds patience) {
  uploader_.Wake();
  uploader_.WaitUntilDone(attempt_, patience);
  return uploader_.state(attempt_);
}

}  // namespace enamel::station
