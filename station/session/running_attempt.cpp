#include "station/session/running_attempt.h"

#include <spdlog/spdlog.h>

#include "station/loop/realtime.h"

namespace enamel::station {
namespace {

using std::chrono::milliseconds;

constexpr size_t kRingTicks = 4000;  // 4 s at 1 kHz before a slow disk makes a gap
constexpr milliseconds kRecorderIdle{2};
constexpr milliseconds kSpoolRetry{200};
constexpr int kSpoolRetries = 25;

}  // namespace

RunningAttempt::RunningAttempt(const Credentials& credentials, Spool& spool,
                               const PreparedAttempt& prepared, Device& device,
                               const AttemptOptions& options)
    : attempt_(prepared.attempt()),
      core_(prepared.header.params, prepared.volume),
      ring_(kRingTicks),
      recorder_(spool, ring_, attempt_, HashSha256(trace::EncodeHeader(prepared.header)),
                credentials.secret_key),
      loop_(device, core_, ring_,
            {prepared.header.params.rate_hz, options.lockstep, options.faults_when_late},
            options.observer),
      uploader_(credentials, spool, attempt_) {
  recorder_thread_ = std::thread([this] { Record(); });
  loop_thread_ = std::thread([this, lockstep = options.lockstep] { RunLoop(lockstep); });
}

RunningAttempt::~RunningAttempt() {
  End();
  (void)Join();
}

void RunningAttempt::RunLoop(bool lockstep) {
  if (!lockstep) {
    RealtimeGrant grant = RequestRealtime();
    if (!grant.refused.empty()) spdlog::warn("{}", grant.refused);
  }
  loop_.Run();
}

void RunningAttempt::Record() {
  int failures = 0;
  while (!recorded_) {
    bool ended = loop_.finished();  // asked before Pump: nothing comes after it
    uint32_t before = recorder_.chunks();
    auto moved = recorder_.Pump();
    {
      std::lock_guard lock(mutex_);
      problem_ = moved.status();
    }
    if (!moved.ok()) {
      if (++failures == 1) spdlog::error("{}", moved.status().message());
      if (failures == kSpoolRetries) {
        loop_.RequestStop();
        recorded_ = moved.status();
      }
      std::this_thread::sleep_for(kSpoolRetry);
      continue;
    }
    failures = 0;
    if (recorder_.chunks() != before) uploader_.Wake();
    if (*moved) continue;
    if (ended)
      recorded_ = recorder_.Finish();
    else
      std::this_thread::sleep_for(kRecorderIdle);
  }
  uploader_.Wake();
}

RunningAttempt::Recording RunningAttempt::recording() const {
  std::lock_guard lock(mutex_);
  return {recorder_.chunks(), recorder_.ticks(), problem_};
}

Result<trace::Seal> RunningAttempt::Join() {
  if (loop_thread_.joinable()) loop_thread_.join();
  if (recorder_thread_.joinable()) recorder_thread_.join();
  return *recorded_;
}

Uploader::State RunningAttempt::AwaitUpload(milliseconds patience) {
  uploader_.Wake();
  uploader_.WaitUntilDone(patience);
  return uploader_.state();
}

}  // namespace enamel::station
