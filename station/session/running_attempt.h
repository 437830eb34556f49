#pragma once

#include <atomic>
#include <boost/json/fwd.hpp>
#include <memory>
#include <optional>
#include <thread>

#include "common/base/mutex.h"
#include "station/loop/tick_loop.h"
#include "station/session/prepared_attempt.h"
#include "station/session/stop_signals.h"
#include "station/spool/recorder.h"
#include "station/uplink/uploader.h"

namespace enamel::station {

struct AttemptOptions {
  // As fast as the machine can, waiting for the recorder: simulated devices only.
  bool lockstep = false;
  // False for devices whose time stops while the loop is late (tick_loop.h).
  bool faults_when_late = true;
  TickObserver* observer = nullptr;  // outlives the attempt; may be null
  int cpu = -1;                      // bind the loop to this processor; -1: to none
  const std::atomic<int>* stops_asked = &StopsAsked();  // TickLoopOptions
};

TickLoopOptions LoopOptionsOf(const PreparedAttempt& prepared, const AttemptOptions& options);

// An attempt from its first tick to its last acknowledgement: tick loop, recorder and uplink on
// their own threads.
//
//   device -> loop (core) -> ring -> recorder -> spool -> uplink
//
// If the spool cannot take a chunk (disk full, not writable, broken), force and cut end with the
// next tick: nothing is felt that is not recorded. Samples already taken stay in memory and are
// tried again several times a second, followed by the seal, until they are stored or GiveUp is
// called. Once they are stored, ticks are stepped again after a declared gap. When the loop ends,
// its facts are kept with the recording (SpooledLoopFacts). The end, and each fault as it comes and
// goes, are logged.
//
// Only End, or the device's kFinish, hands an attempt in. Whatever else ends it (Leave, the
// destructor, a stop that its owner does not see in time: TickLoopOptions) stores all ticks and no
// seal, so that its person can resume it.
//
// Thread safety: one owner's thread, but End, Leave, GiveUp, Join, ticking and the states from any.
// Real-time: never; only the loop inside is.
class RunningAttempt : private TickObserver {
 public:
  struct Recording {
    uint32_t chunks = 0;         // durable in the spool
    uint64_t ticks = 0;          // durable in the spool
    uint64_t waiting_ticks = 0;  // in memory only
    Status problem;              // why the spool takes nothing at the moment, or ok
  };

  // Starts ticking. Takes over a resumed attempt's core. The spool must know the attempt; all
  // arguments outlive this. `lock` is the spool's.
  RunningAttempt(const trace::SecretKey& station_key, Spool& spool, Uploader& uploader,
                 PreparedAttempt& prepared, Device& device, const AttemptOptions& options,
                 RecordingLock lock);
  ~RunningAttempt() override;  // Leave
  RunningAttempt(const RunningAttempt&) = delete;
  RunningAttempt& operator=(const RunningAttempt&) = delete;

  const Uuid& attempt() const { return attempt_; }
  // Ends the attempt early; otherwise it ends when the device reports kFinish.
  void End();
  // Ends the loop, with force 0, and stores what it recorded. Unless the attempt had ended, it has no
  // seal: it can be resumed, and Join must not be called. A disk that takes nothing is tried once more.
  // Errors: what is stored and what is lost. May be called again, and after End.
  Status Leave();
  bool ticking() const { return !loop_.finished(); }
  // It was left before its end: it has no seal, and can be resumed.
  bool left() const { return left_ || (loop_.finished() && loop_.stopped_itself()); }
  // The system refused the loop's priority or memory lock (realtime.h), so that other programs can
  // make ticks late. False until the loop has asked.
  bool lacks_realtime() const { return lacks_realtime_; }
  // Stops waiting for a spool that takes nothing: it is tried once more after the end, then samples
  // in memory are lost.
  void GiveUp() { give_up_ = true; }
  // The recording is whole on disk, or given up: Join does not wait any longer.
  bool recorded() const { return done_; }
  TickLoop& loop() { return loop_; }
  // Newest tick, for one reader thread.
  const Snapshot& snapshot() { return loop_.snapshot(); }
  Recording recording() const;
  Uploader::State upload() const { return uploader_.state(attempt_); }
  // The oldest message to this chair that was not shown yet. Call RemarkShown once somebody sees
  // it; the server is notified.
  std::optional<protocol::Remark> remark() const { return uploader_.remarks().Next(attempt_); }
  void RemarkShown(uint64_t id) { uploader_.remarks().Shown(attempt_, id); }

  // Waits for the loop's end and the seal. Errors: the recording is incomplete on disk, with what
  // is stored and what to do. May be called again. Requires: not left before its end.
  Result<trace::Seal> Join();
  // Facts of the loop (loop_facts.h). Requires: Join or Leave has returned.
  boost::json::object facts() const;
  // The tooth in its final state. Requires: Join or Leave has returned.
  const core::Core& core() const { return *core_; }
  // The same, to continue with (UnrecordedRun); core() must not be asked any more. Requires: Join has
  // returned.
  std::unique_ptr<core::Core> TakeCore() { return std::move(core_); }
  // After Join: waits until everything is durable on the server, or the server refuses for good or
  // has not been reachable for `patience`. The upload continues afterwards.
  Uploader::State AwaitUpload(std::chrono::milliseconds patience);

 private:
  void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;
  void RunLoop(const AttemptOptions& options);
  void Record();
  std::optional<Status> RecordOnce();
  Status Close();
  void AwaitThreads();
  void Note(const Status& problem);
  Status Lost(const Status& why) const;
  void KeepFacts();
  void LogFaults();
  void LogEnd(const Status& status) const;

  std::optional<RecordingLock> lock_;  // until the recording is whole
  const Uuid attempt_;
  Spool& spool_;
  Device& device_;
  Uploader& uploader_;
  TickObserver* const observer_;
  const uint32_t rate_hz_;
  const uint64_t live_every_;  // ticks
  const std::shared_ptr<LiveMailbox> live_ = std::make_shared<LiveMailbox>();
  std::unique_ptr<core::Core> core_;
  SampleRing ring_;
  Recorder recorder_;
  TickLoop loop_;
  std::atomic<bool> give_up_{false}, done_{false}, ended_{false}, left_{false},
      lacks_realtime_{false};
  Fault logged_ = Fault::kNone;  // of the recorder's thread
  Mutex joining_;
  mutable Mutex mutex_;
  Status problem_ ENAMEL_GUARDED_BY(mutex_);
  // The recorder's, then Join's and Leave's. A seal: unless it was left.
  std::optional<Status> recorded_;
  std::optional<trace::Seal> seal_;
  std::thread recorder_thread_, loop_thread_;
};

}  // namespace enamel::station
