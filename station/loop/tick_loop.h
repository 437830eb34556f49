#pragma once

#include <atomic>
#include <cstdint>

#include "common/base/triple_buffer.h"
#include "common/core/core.h"
#include "common/trace/trace.h"
#include "station/devices/device.h"
#include "station/loop/spsc_ring.h"

namespace enamel::station {

// One stepped tick on its way to the recorder.
struct Sample {
  trace::Tick tick;
  uint64_t state_hash = 0;  // core's, after this tick
};
using SampleRing = SpscRing<Sample>;

// Counters of a loop, as of one tick.
struct LoopCounters {
  uint64_t ticks = 0;      // stepped and recorded
  uint64_t gap_ticks = 0;  // not stepped, because they could not be recorded
  uint64_t late_ticks = 0;
  uint64_t faults = 0;
  uint64_t bounded_ticks = 0;  // the force was limited to the device's
};

// What the loop shows of its newest tick: to the picture, the progress line and the live view.
struct Snapshot {
  LoopCounters counters;
  cutting::Pose anchor;
  cutting::Pose device;
  dvec3 force_sent_n{0};
  cutting::RemovedUnits removed{};  // since the start
  uint8_t input_flags = 0;          // core::InputFlags
  uint16_t output_flags = 0;
};

// Sees each stepped tick on the tick's own thread: for the window's mailbox. Real-time.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  ENAMEL_REALTIME virtual void OnTick(const core::Core& core,
                                      const Snapshot& snapshot) noexcept = 0;
};

struct TickLoopOptions {
  uint32_t rate_hz = 1000;
  // As fast as the machine can, waiting for the recorder instead of dropping: simulated devices
  // only. Otherwise ticks come at rate_hz and a full ring makes a declared gap.
  bool lockstep = false;
  // A device whose time does not pass while the loop is late (a simulated one) is not put at risk
  // by late ticks: they are counted and recorded, no fault is latched.
  bool faults_when_late = true;
};

// Why a fault was latched: force zero, no cutting, until the operator acts.
enum class Fault : uint8_t { kNone = 0, kStalled, kLateOnce, kLateOften, kReserve };

// The haptic loop: device -> core -> device, and what was done to the ring and the snapshot.
//
// Late ticks (haptics.md section 4): a tick late by a whole period is flagged; by 5 ms, or more
// than 20 late ones within a second, latches a fault, as does a device that says nothing new for
// 5 ms. The fault ends when the operator releases the pedal and presses it again; the core then
// switches force and cutting on once the bur has been in free air (core.h).
//
// Thread safety: Run and Tick on one thread; RequestStop, snapshot() (one reader) and counters from
// others. Real-time: Tick is safe; Run sleeps between ticks and does nothing else.
class TickLoop {
 public:
  // All must outlive the loop; `observer` may be null.
  TickLoop(Device& device, core::Core& core, SampleRing& ring, const TickLoopOptions& options,
           TickObserver* observer = nullptr);

  // Until the device reports kFinish or RequestStop. On return the device holds zero force.
  void Run() noexcept;
  void RequestStop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  // Run has returned; all samples are in the ring.
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }

  // One tick, `late_s` after it was due. True when the operator has finished. The whole chain from
  // the device's counts to its motors is in this function.
  ENAMEL_REALTIME bool Tick(double late_s = 0) noexcept;

  // Newest tick, for one reader thread.
  const Snapshot& snapshot() noexcept { return snapshots_.Read(); }
  Fault fault() const noexcept { return fault_; }

 private:
  core::TickInput InputOf(const DeviceSample& sample) noexcept;
  void WatchTime(const DeviceSample& sample, double late_s) noexcept;
  void Latch(Fault fault) noexcept;
  void Publish(const core::TickInput& input, const core::TickOutput& out) noexcept;

  Device& device_;
  core::Core& core_;
  SampleRing& ring_;
  const TickLoopOptions options_;
  TickObserver* const observer_;
  TripleBuffer<Snapshot> snapshots_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> finished_{false};

  // Owned by the tick's thread.
  LoopCounters counters_;
  uint32_t gap_ = 0;  // ticks not stepped since the last sample
  bool late_ = false;
  Fault fault_ = Fault::kNone;
  bool pedal_released_ = false;  // since the fault
  bool soft_restart_ = false;
  double silent_s_ = 0;  // since the device said something new
  double late_window_s_ = 0;
  int late_in_window_ = 0;
};

}  // namespace enamel::station
