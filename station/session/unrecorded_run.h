#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "station/session/running_attempt.h"

namespace enamel::station {

// A loop of which nothing is kept: to try a device before an attempt, or to cut on for practice
// after one. Needs no ticket, spool or server. Its samples are read and dropped, so that it runs as
// an attempt's does. Thread safety: one owner's thread. Real-time: never; only the loop inside is.
class UnrecordedRun : private TickObserver {
 public:
  // What was seen so far.
  struct Found {
    uint64_t ticks = 0, late_ticks = 0, faults = 0;
    double turning_s = 0;     // with the bur on
    double peak_force_n = 0;  // largest sent
  };

  // Starts ticking. A core that ticked before continues after a gap: without force until the bur has
  // been in free air. `prepared` and `device` outlive this.
  UnrecordedRun(std::unique_ptr<core::Core> core, const PreparedAttempt& prepared, Device& device,
                const AttemptOptions& options);
  ~UnrecordedRun() override { End(); }

  // Waits for the loop's end: then the device holds zero force.
  void End();
  // The tooth as it was left, to continue with. Requires: End has returned.
  std::unique_ptr<core::Core> TakeCore() { return std::move(core_); }
  bool ticking() const { return !loop_.finished(); }
  TickLoop& loop() { return loop_; }
  // Newest tick, for one reader thread.
  const Snapshot& snapshot() { return loop_.snapshot(); }
  Found found();
  // As RunningAttempt's.
  bool lacks_realtime() const { return lacks_realtime_; }

 private:
  void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override;
  void Drop();

  TickObserver* const observer_;
  const double tick_s_;
  std::unique_ptr<core::Core> core_;
  SampleRing ring_;
  TickLoop loop_;
  // Written by the tick.
  std::atomic<uint64_t> turning_ticks_{0};
  std::atomic<double> peak_force_n_{0};
  std::atomic<bool> lacks_realtime_{false};
  std::thread dropper_, ticker_;
};

}  // namespace enamel::station
