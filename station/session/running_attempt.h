#pragma once

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
// A spool that cannot take a chunk is tried again for some seconds, while the ring fills and then
// ticks are not stepped (a declared gap); if it still cannot, the attempt ends, and what is on disk
// stays there. Thread safety: one owner's thread, but End, ticking and the states from any.
// Real-time: never; only the loop inside is.
class RunningAttempt : private TickObserver {
 public:
  struct Recording {
    uint32_t chunks = 0;  // durable in the spool
    uint64_t ticks = 0;
    Status problem;  // why the spool takes nothing just now, or ok
  };

  // Starts ticking. Takes the core of one that is resumed. The spool must know the attempt; all
  // outlive this. `lock` is the spool's.
  RunningAttempt(const trace::SecretKey& station_key, Spool& spool, Uploader& uploader,
                 PreparedAttempt& prepared, Device& device, const AttemptOptions& options,
                 RecordingLock lock);
  ~RunningAttempt() override;  // ends and seals it if need be
  RunningAttempt(const RunningAttempt&) = delete;
  RunningAttempt& operator=(const RunningAttempt&) = delete;

  const Uuid& attempt() const { return attempt_; }
  // Ends it early; without this it ends when the device says kFinish.
  void End() { loop_.RequestStop(); }
  bool ticking() const { return !loop_.finished(); }
  TickLoop& loop() { return loop_; }
  // Newest tick, for one reader thread.
  const Snapshot& snapshot() { return loop_.snapshot(); }
  Recording recording() const;
  Uploader::State upload() const { return uploader_.state(attempt_); }

  // Waits for the loop's end and the seal. Errors: the recording is not complete on disk. May be
  // called again.
  Result<trace::Seal> Join();
  // The tooth as it is now. Requires: Join has returned.
  const core::Core& core() const { return *core_; }
  // After Join: until everything is durable on the server, it refuses for good, or has not been
  // reachable for `patience`. The upload goes on afterwards.
  Uploader::State AwaitUpload(std::chrono::milliseconds patience);

 private:
  void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;
  void RunLoop(const AttemptOptions& options);
  void Record();

  std::optional<RecordingLock> lock_;  // until the recording is whole
  const Uuid attempt_;
  Uploader& uploader_;
  TickObserver* const observer_;
  const uint64_t live_every_;  // ticks
  const std::shared_ptr<LiveMailbox> live_ = std::make_shared<LiveMailbox>();
  std::unique_ptr<core::Core> core_;
  SampleRing ring_;
  Recorder recorder_;
  TickLoop loop_;
  mutable std::mutex mutex_;
  Status problem_;                               // guarded by mutex_
  std::optional<Result<trace::Seal>> recorded_;  // the recorder's, then Join's
  std::thread recorder_thread_, loop_thread_;
};

}  // namespace enamel::station
