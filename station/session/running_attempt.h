#pragma once

#include <atomic>
#include <boost/json/fwd.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "station/loop/tick_loop.h"
#include "station/session/prepared_attempt.h"
#include "station/spool/recorder.h"
#include "station/uplink/uploader.h"

namespace enamel::station {

struct AttemptOptions {
  // As fast as the machine can, waiting for the recorder: simulated devices only.
  bool lockstep = false;
  // False for devices whose time does not pass while the loop is late (tick_loop.h).
  bool faults_when_late = true;
  TickObserver* observer = nullptr;  // outlives the attempt; may be null
  int cpu = -1;                      // bind the loop to this processor; -1: to none
};

// An attempt between its first tick and its last acknowledgement: tick loop, recorder and uplink on
// threads of their own.
//
//   device -> loop (core) -> ring -> recorder -> spool -> uplink
//
// A spool that cannot take a chunk (disk full, not writable, broken) ends force and cut with the
// next tick: nothing is felt that is not recorded. What was felt before is kept in memory and tried
// again several times a second, the seal after it, until it is stored or GiveUp; once it is, ticks
// are stepped again after a declared gap. How the loop went is kept beside the recording when it
// ends (SpooledLoopFacts). Its end, and each fault as it comes and goes, are logged.
// Thread safety: one owner's thread, but End, GiveUp, ticking and the states from any.
// Real-time: never; only the loop inside is.
class RunningAttempt : private TickObserver {
 public:
  struct Recording {
    uint32_t chunks = 0;         // durable in the spool
    uint64_t ticks = 0;          // durable in the spool
    uint64_t waiting_ticks = 0;  // that are in memory
    Status problem;              // why the spool takes nothing just now, or ok
  };

  // Starts ticking. Takes the core of one that is resumed. The spool must know the attempt; all
  // outlive this. `lock` is the spool's.
  RunningAttempt(const trace::SecretKey& station_key, Spool& spool, Uploader& uploader,
                 PreparedAttempt& prepared, Device& device, const AttemptOptions& options,
                 RecordingLock lock);
  ~RunningAttempt() override;  // ends and seals it if need be; GiveUp
  RunningAttempt(const RunningAttempt&) = delete;
  RunningAttempt& operator=(const RunningAttempt&) = delete;

  const Uuid& attempt() const { return attempt_; }
  // Ends it early; without this it ends when the device says kFinish.
  void End() { loop_.RequestStop(); }
  bool ticking() const { return !loop_.finished(); }
  // A spool that takes nothing is tried once more after the end, then no longer waited for: what is
  // in memory is lost.
  void GiveUp() { give_up_ = true; }
  // It is whole on disk, or given up: Join does not wait any more.
  bool recorded() const { return done_; }
  TickLoop& loop() { return loop_; }
  // Newest tick, for one reader thread.
  const Snapshot& snapshot() { return loop_.snapshot(); }
  Recording recording() const;
  Uploader::State upload() const { return uploader_.state(attempt_); }
  // What was said to this chair and not shown yet, oldest first; RemarkShown once it is before
  // somebody's eyes, which the server is told.
  std::optional<protocol::Remark> remark() const { return uploader_.remarks().Next(attempt_); }
  void RemarkShown(uint64_t id) { uploader_.remarks().Shown(attempt_, id); }

  // Waits for the loop's end and the seal. Errors: the recording is not complete on disk (says what
  // of it is, and what to do). May be called again.
  Result<trace::Seal> Join();
  // How the loop went (loop_facts.h). Requires: Join has returned.
  boost::json::object facts() const;
  // The tooth as it is now. Requires: Join has returned.
  const core::Core& core() const { return *core_; }
  // After Join: until everything is durable on the server, it refuses for good, or has not been
  // reachable for `patience`. The upload goes on afterwards.
  Uploader::State AwaitUpload(std::chrono::milliseconds patience);

 private:
  void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;
  void RunLoop(const AttemptOptions& options);
  void Record();
  std::optional<Result<trace::Seal>> RecordOnce();
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
  std::atomic<bool> give_up_{false}, done_{false};
  Fault logged_ = Fault::kNone;  // of the recorder's thread
  mutable std::mutex mutex_;
  Status problem_;                               // guarded by mutex_
  std::optional<Result<trace::Seal>> recorded_;  // the recorder's, then Join's
  std::thread recorder_thread_, loop_thread_;
};

}  // namespace enamel::station
