#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "common/base/triple_buffer.h"
#include "common/core/core.h"
#include "common/trace/trace.h"
#include "station/devices/device.h"
#include "station/devices/duration_histogram.h"
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
  uint64_t ticks = 0;  // stepped and recorded
  // Not stepped, because they could not be recorded or an interruption was ridden out.
  uint64_t gap_ticks = 0;
  uint64_t skipped_ticks = 0;  // not stepped, because they passed while a tick was late
  uint64_t late_ticks = 0;     // began a whole period late, or more
  uint64_t faults = 0;
  uint64_t interruptions = 0;  // ridden out without a fault
  uint64_t bounded_ticks = 0;  // the force was limited to the device's
  uint64_t stale_ticks = 0;    // stepped without anything new from the device
  uint64_t put_downs = 0;      // times the handpiece was put into its holder
  // Upper bound of the energy that late and stale ticks may have released, J (see "Leak" below), but
  // for the last 5 ms before a fault: where the tip went meanwhile is unknown.
  double leak_j = 0;

  // The attempt's ticks that passed, stepped or declared as a gap.
  uint64_t passed_ticks() const noexcept { return ticks + missed_ticks(); }
  // Of them, those in gaps, whatever made the gap.
  uint64_t missed_ticks() const noexcept { return gap_ticks + skipped_ticks; }
};

// Why there is no force and no cut at present.
enum class Fault : uint8_t {
  kNone = 0,
  kStalled,
  kLateOnce,
  kLateOften,
  kTooSlow,
  kUnplugged,
  kSwitchedOff
};
// The fault and its remedy, for the operator. Without a full stop.
const char* FaultText(Fault fault) noexcept;

// The loop's newest tick, for the picture, the progress line and the live view.
struct Snapshot {
  LoopCounters counters;
  cutting::Pose anchor;
  cutting::Pose device;
  double bur_speed_ratio = 1;  // core::TickOutput
  dvec3 pressed_n{0};  // core::TickOutput::pressed_n: on the hand, the device's friction among it
  cutting::RemovedUnits removed{};  // since the start
  uint8_t input_flags = 0;          // core::InputFlags
  uint16_t output_flags = 0;
  Fault fault = Fault::kNone;
  bool put_down = false;   // the handpiece lies in its holder
  uint8_t bur = 0;         // the number of the bur in the handpiece
  bool bur_waits = false;  // another is wanted, and comes once this one is out of the tooth
};

// One tick of a fault's record.
struct FaultTick {
  core::TickInput input;
  dvec3 force_sent_n{0};
  double late_s = 0;
  bool fresh = true, attached = true, driven = true;
};

// A fault and the ticks that led to it; the last is the tick that latched it.
struct FaultRecord {
  static constexpr size_t kTicks = 64;
  Fault fault = Fault::kNone;
  uint64_t tick = 0;  // stepped ticks before it
  size_t count = 0;   // of ticks
  std::array<FaultTick, kTicks> ticks{};
};

// Called with each stepped tick on the tick's own thread, for the window's mailbox. Real-time.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  ENAMEL_REALTIME virtual void OnTick(const core::Core& core,
                                      const Snapshot& snapshot) noexcept = 0;
};

struct TickLoopOptions {
  uint32_t rate_hz = 1000;
  // Runs as fast as the machine can and waits for the recorder instead of dropping: simulated
  // devices only. Otherwise ticks come at rate_hz and a full ring makes a declared gap.
  bool lockstep = false;
  // False for a device whose time stops while the loop is late (a simulated one): late ticks are
  // counted and recorded, and latch no fault.
  bool faults_when_late = true;
  // b of the device, for the leak's bound. 0 bounds it for any device.
  double damping_n_s_per_m = 0;
  double rotational_damping_n_m_s = 0;  // b_rot, for the same bound
  // For an attempt resumed after a crash: ticks stepped before, and ticks that passed since without
  // being stepped. The first tick declares that gap and keeps force and cutting off until the bur
  // is in free air.
  uint64_t ticks_before = 0;
  uint32_t first_gap_ticks = 0;
  // How often the program was asked to end. The loop's owner then stops it, within a frame. An owner
  // may hang in a call to a window system that no longer answers; Run then ends by itself,
  // kStopPatience_ns after the first time, so that no device keeps its force. Null: nobody asks.
  const std::atomic<int>* stops_asked = nullptr;
};

// The haptic loop: device -> core -> device; the result goes to the ring and the snapshot.
//
// Late ticks (common/haptics/README.md, "Late and lost ticks"): a tick late by a whole period is
// flagged. An interruption is a tick that is late by 5 ms, or a device that reports nothing new for
// 5 ms. The force is 0 from the tick that sees it. Fading would gain nothing, since a falling force
// can release no energy, and 0 is reached sooner than the 20 ms allowed.
//
// A single short interruption is ridden out: its ticks are not stepped and form a declared gap
// without force. When the device answers again and the forces under way have ended, the cut
// continues where it was, as after any short gap (core.h), with no more force than the tank pays
// for. Short is kRideFor_s; single means that none ended within kRideAgain_s before.
//
// These are a fault: any other interruption, more than 20 late ticks or leaking holds (see "Leak")
// within any second, and at once a device that is unplugged or has switched its force off. The
// fault shown is the present one: a silent device that turns out to be unplugged is unplugged. A
// fault ends by itself once the device has been alive for kRecover_s, and after lateness once no
// tick was late for a second. Force and cut then return as at the start. The operator need not act:
// force begins at 0 in free air, wherever the pedal is. The last FaultRecord::kTicks ticks of the
// first kMaxRecords faults are kept.
//
// Time that passed is in the recording: whole periods that pass while a tick is late are declared
// as a gap before it. If the force was held over them (core::kHeldGap), they were less than 5 ms,
// so declaring the gap is not felt. Ticks that could not be recorded are a gap without force. Ticks
// and gaps together are the attempt's time, by the clock.
//
// When the device's axes are turned in the scene (DeviceSample::turned) the tip jumps. Force and cut
// are off from that tick on, and come on as at the start.
//
// While the handpiece is in its holder (kPutDown) it has no force and its bur is stopped. When it
// is taken up, the force comes on as at the start. The attempt continues.
//
// A bur is changed away from the tooth or while force is off, else it waits for that: the core switches force off at
// a change (core.h), which would be felt in the tooth.
//
// Force comes on softly: only after the device has been still for as long as it asks
// (Device::still_before_force_s; still means within 0.5 mm on each axis), and then only in free air
// (core.h), where it is 0 and grows with the way into the tooth.
//
// Leak: while a force is held for T_hold, longer than a tick, and the tip moves by dx meanwhile,
// the operator can receive at most max(0, Kc/2 - b/T_hold) |dx|^2. For a torque over an angle the
// same formula holds with its own numbers. The sum is in the counters. A hold leaks when this is
// more than Kc/2 S^2, S the radius of the device's cell: within its cell nobody knows where the tip
// was. So a device that reports less often than the coupling assumes cannot go on leaking: that is
// Fault::kTooSlow.
//
// Thread safety: Run and Tick on one thread; RequestStop, Hold, WantBur, fault(), snapshot() (one reader),
// lateness() and durations() from others. Real-time: Tick is safe; Run only adds the sleep between
// ticks.
class TickLoop {
 public:
  // All must outlive the loop; `observer` may be null.
  TickLoop(Device& device, core::Core& core, SampleRing& ring, const TickLoopOptions& options,
           TickObserver* observer = nullptr);

  // Runs until the device reports kFinish (a simulated hand's) or RequestStop. On return the device
  // holds zero force.
  void Run() noexcept;
  void RequestStop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  // Hold(true): from the next tick on none is stepped until Hold(false), as with a full ring,
  // because the last samples cannot be stored. No force, no cut, a declared gap.
  void Hold(bool held) noexcept { held_.store(held, std::memory_order_relaxed); }
  // The number of the bur that the handpiece is to have. Requires: bur < core::BurCount(the core's parameters).
  void WantBur(size_t bur) noexcept {
    wanted_bur_.store(static_cast<uint8_t>(bur), std::memory_order_relaxed);
  }
  // Run has returned; all samples are in the ring.
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }
  // Run ended by itself because the program was asked to end. After finished().
  bool stopped_itself() const noexcept { return stopped_itself_; }

  // One tick, `late_s` (not below 0) after it was due. The next one is due a tick after this one
  // was due, plus the whole periods that this one is late by. True when the operator has finished.
  // The whole chain from the device's counts to its motors is in this function.
  ENAMEL_REALTIME bool Tick(double late_s = 0) noexcept;

  // Newest tick, for one reader thread.
  const Snapshot& snapshot() noexcept { return snapshots_.Read(); }
  // The current fault, also between ticks that are not stepped. By any thread.
  Fault fault() const noexcept { return fault_.load(std::memory_order_relaxed); }
  // All counts, also of ticks that were not stepped. On the tick's thread, or after finished().
  const LoopCounters& counters() const noexcept { return counters_; }
  // Oldest first. On the tick's thread, or after finished().
  std::span<const FaultRecord> fault_records() const noexcept { return {records_, record_count_}; }
  // Lateness of the start of Run's ticks, and their duration. Lockstep fills neither.
  const DurationHistogram& lateness() const noexcept { return lateness_; }
  const DurationHistogram& durations() const noexcept { return durations_; }

  static constexpr size_t kMaxRecords = 8;
  static constexpr int64_t kStopPatience_ns = 1'000'000'000;
  static constexpr int kLateTicksPerSecond = 20;
  // Shorter than a person's reaction to a touch, about 0.15 s (Welford, Reaction Times, 1980): the
  // hand does by then what it did before.
  static constexpr double kRideFor_s = 0.1;
  static constexpr double kRideAgain_s = 1.0;  // chosen, as the window of late ticks
  static constexpr double kRecover_s = 0.25;   // chosen: longer than a contact that bounces

 private:
  bool CannotRecord() const noexcept {
    return held_.load(std::memory_order_relaxed) || ring_.Full();
  }
  void Skip() noexcept;
  core::TickInput InputOf(const DeviceSample& sample) noexcept;
  void Send(const core::TickOutput& out) noexcept;
  void WatchTime(const DeviceSample& sample, double late_s) noexcept;
  void WatchLateness(double late_s, bool leaks) noexcept;
  void Interrupt(Fault fault, double for_s) noexcept;
  void WatchRide(const DeviceSample& sample) noexcept;
  void WatchRecovery(const DeviceSample& sample) noexcept;
  void WatchTurn(const DeviceSample& sample) noexcept;
  void WatchHolder(const DeviceSample& sample) noexcept;
  void WatchStillness(const DeviceSample& sample) noexcept;
  void AwaitStillness() noexcept;
  bool AddLeak(const DeviceSample& sample, double hold_s) noexcept;
  bool DeviceAlive(const DeviceSample& sample) const noexcept;
  bool IsStopOverdue() noexcept;
  void Latch(Fault fault) noexcept;
  void Remember(const DeviceSample& sample, const core::TickInput& input, const dvec3& sent_n,
                double late_s) noexcept;
  void Publish(const core::TickInput& input, const core::TickOutput& out) noexcept;

  Device& device_;
  core::Core& core_;
  SampleRing& ring_;
  const TickLoopOptions options_;
  TickObserver* const observer_;
  TripleBuffer<Snapshot> snapshots_;
  std::atomic<bool> stop_{false}, held_{false};
  std::atomic<bool> finished_{false};
  bool stopped_itself_ = false;
  std::atomic<uint8_t> wanted_bur_;

  // Owned by the tick's thread.
  int64_t stop_asked_ns_ = 0;  // when it was first seen; 0: not yet
  LoopCounters counters_;
  uint32_t gap_ = 0;      // ticks not stepped since the last sample
  bool gap_held_ = true;  // all of them passed while a tick was late
  uint64_t skipped_ = 0;  // whole periods this tick is late by
  double rest_s_ = 0;     // lateness of the last tick beyond whole periods
  bool put_down_ = false, holder_known_ = false;
  std::atomic<Fault> fault_{Fault::kNone};  // written by the tick
  bool soft_restart_ = false;
  Fault ride_ = Fault::kNone;  // what is being ridden out
  double ride_since_s_ = 0, ride_ended_s_ = -kRideAgain_s;
  double alive_since_s_ = 0;            // while a fault lasts
  double last_late_s_ = -kRideAgain_s;  // or leaking hold
  double cell_energy_j_ = 0;            // Kc/2 S^2
  double now_s_ = 0;                    // of the attempt, by the ticks that were due
  double silent_s_ = 0;  // since the device last reported something new, by the clock
  std::array<double, kLateTicksPerSecond> late_at_s_{};  // ring of the last late ticks' times
  uint64_t late_count_ = 0;                              // since the last fault
  uint64_t still_ticks_needed_ = 0, still_ticks_ = 0;
  bool await_still_ = false;
  std::array<int32_t, 3> still_at_{}, last_counts_{};
  QuantisedOrientation last_orientation_ = kIdentityOrientation;
  bool has_last_ = false;
  std::array<FaultTick, FaultRecord::kTicks> history_{};  // ring
  uint64_t history_count_ = 0;
  FaultRecord records_[kMaxRecords];
  size_t record_count_ = 0;
  bool record_due_ = false;
  DurationHistogram lateness_, durations_;
};

}  // namespace enamel::station
