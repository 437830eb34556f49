#include "station/loop/tick_loop.h"

#include <time.h>

#include <utility>

namespace enamel::station {
namespace {

// The same 5 ms as "silent" in schemas/hid_haptic_report.md. AddLeak sums the energy that may be
// released within them.
constexpr double kInterruptAfter_s = 5e-3;
constexpr double kRounding_s = 1e-9;  // a sum of ticks is compared with a time
constexpr double kLateWindow_s = 1.0;
constexpr double kStillReach_m = 0.5e-3;
constexpr int64_t kSecond_ns = 1'000'000'000;
// How long a lockstep loop waits before it checks a full ring again.
constexpr int64_t kBackPressure_ns = 100'000;

int64_t Now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond_ns + t.tv_nsec;
}

void SleepUntil(int64_t due_ns) noexcept {
  // Until a time, not for a duration, so lateness does not add up. After a signal it continues.
  timespec t{due_ns / kSecond_ns, due_ns % kSecond_ns};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

// A sum that does not fit is held at the maximum.
uint32_t Longer(uint32_t gap, uint64_t by) noexcept {
  return by < UINT32_MAX - gap ? gap + static_cast<uint32_t>(by) : UINT32_MAX;
}

}  // namespace

const char* FaultText(Fault fault) noexcept {
  switch (fault) {
    case Fault::kNone:
      return "";
    case Fault::kStalled:
      return "the device does not answer: check its cable";
    case Fault::kLateOnce:
      return "the computer was busy and held the force too long";
    case Fault::kLateOften:
      return "the computer is too busy for a steady force: close other programs";
    case Fault::kTooSlow:
      return "the device answers too slowly: plug it into the computer itself, without a hub";
    case Fault::kUnplugged:
      return "the device is not connected: plug it in";
    case Fault::kSwitchedOff:
      return "the device has switched its motors off: check its power and its switch";
  }
  return "";
}

TickLoop::TickLoop(Device& device, core::Core& core, SampleRing& ring,
                   const TickLoopOptions& options, TickObserver* observer)
    : device_(device),
      core_(core),
      ring_(ring),
      options_(options),
      observer_(observer),
      wanted_bur_(static_cast<uint8_t>(core.bur())) {
  ENAMEL_CHECK(options_.rate_hz > 0);
  still_ticks_needed_ =
      static_cast<uint64_t>(device.still_before_force_s() * options_.rate_hz + 0.5);
  await_still_ = still_ticks_needed_ > 0;
  const double cell_m = core::TipCellOf(core.params()).Radius();
  cell_energy_j_ = 0.5 * core.params().kc_mn_per_mm * cell_m * cell_m;
  counters_.ticks = options_.ticks_before;
  counters_.gap_ticks = gap_ = options_.first_gap_ticks;
  gap_held_ = gap_ == 0;
  // Nobody watched the time since the crash: as after a fault, free air first.
  soft_restart_ = gap_ > 0;
}

void TickLoop::Run() noexcept {
  const int64_t start_ns = Now_ns();
  int64_t due_ticks = 0;  // since the start
  while (!stop_.load(std::memory_order_relaxed)) {
    if ((stopped_itself_ = IsStopOverdue())) break;
    if (options_.lockstep) {
      if (CannotRecord()) {
        SleepUntil(Now_ns() + kBackPressure_ns);
        continue;
      }
      if (Tick()) break;
      continue;
    }
    due_ticks += 1 + static_cast<int64_t>(skipped_);  // the hand has moved on
    // From the start and in whole numbers: a period of 333 333.3 ns does not drift.
    const int64_t due_ns = start_ns + due_ticks * kSecond_ns / options_.rate_hz;
    SleepUntil(due_ns);
    int64_t begin_ns = Now_ns(), late_ns = begin_ns - due_ns;
    lateness_.Add(late_ns);
    bool finished = Tick(static_cast<double>(late_ns) * 1e-9);
    durations_.Add(Now_ns() - begin_ns);
    if (finished) break;
  }
  device_.SendForceAndTorque(dvec3(0), dvec3(0));
  finished_.store(true, std::memory_order_release);
}

bool TickLoop::IsStopOverdue() noexcept {
  if (options_.stops_asked == nullptr || *options_.stops_asked == 0) return false;
  const int64_t now_ns = Now_ns();
  if (stop_asked_ns_ == 0) stop_asked_ns_ = now_ns;
  return now_ns - stop_asked_ns_ > kStopPatience_ns;
}

bool TickLoop::Tick(double late_s) noexcept {
  DeviceSample sample = device_.ReadSample();
  WatchTurn(sample);
  WatchTime(sample, late_s > 0 ? late_s : 0);
  WatchHolder(sample);
  WatchStillness(sample);
  WatchRide(sample);
  WatchRecovery(sample);
  if (CannotRecord() || ride_ != Fault::kNone) {
    Skip();
    return (sample.buttons & kFinish) != 0;
  }
  core::TickInput input = InputOf(sample);
  core::TickOutput out = core_.Step(input);  // finite check, law, bound, finite check (coupling.h)
  Send(out);
  ring_.Push({{input, out.witness}, core_.state_hash()});
  Remember(sample, input, out.force_sent_n, late_s);
  Publish(input, out);
  device_.ShowBur(out.anchor.tip_m);
  return (sample.buttons & kFinish) != 0;
}

// Not stepped: no force, no cut, a declared gap.
void TickLoop::Skip() noexcept {
  gap_ = Longer(gap_, 1);
  gap_held_ = false;
  ++counters_.gap_ticks;
  device_.SendForceAndTorque(dvec3(0), dvec3(0));
}

void TickLoop::Send(const core::TickOutput& out) noexcept {
  if (!core_.params().spring_on_board) {
    device_.SendForceAndTorque(out.force_sent_n, out.torque_sent_n_m);
    return;
  }
  SpringCommand command;
  command.on = out.spring.on;
  command.follow = out.spring.follow;
  command.rest_nm = out.spring.rest_nm;
  command.added_n = out.cue_n;
  command.torque_n_m = out.torque_sent_n_m;
  command.bound_n = core_.params().peak_force_mn * 1e-3;
  device_.SendSpring(command);
}

core::TickInput TickLoop::InputOf(const DeviceSample& sample) noexcept {
  const bool pedal = (sample.buttons & kPedal) != 0 && !put_down_;
  core::TickInput input;
  input.counts = sample.counts;
  input.orientation = sample.orientation;
  input.bur_speed_krpm = sample.bur_speed_krpm;
  input.gap_ticks = gap_;
  if (core_.params().spring_on_board) {
    input.rest_off_nm = core_.RestOff_nm(sample.counts, sample.rest_nm);
    input.share_lost = static_cast<uint16_t>(65'535 - sample.share);
  }
  if (gap_ > 0 && gap_held_) input.flags |= core::kHeldGap;
  gap_ = 0;
  gap_held_ = true;
  if (pedal) input.flags |= core::kBurOn;
  if (skipped_ > 0) input.flags |= core::kLateTick;
  if (fault() != Fault::kNone) input.flags |= core::kFaulted;
  if (soft_restart_ || await_still_ || put_down_) input.flags |= core::kSoftRestart;
  soft_restart_ = false;
  const size_t wanted = wanted_bur_.load(std::memory_order_relaxed);
  const bool changes = wanted != core_.bur() && core_.OutOfTooth();
  input.flags |= core::BurFlags(changes ? wanted : core_.bur());
  return input;
}

void TickLoop::WatchTime(const DeviceSample& sample, double late_s) noexcept {
  const double tick_s = 1.0 / options_.rate_hz;
  skipped_ = static_cast<uint64_t>((late_s + kRounding_s) * options_.rate_hz);
  const double skipped_s = static_cast<double>(skipped_) * tick_s;
  // In a loop that is steadily 0.9 ms late each tick still comes a tick after the last: only the
  // change of lateness is time that passed.
  const double since_last_s = tick_s + late_s - rest_s_;
  rest_s_ = late_s - skipped_s;
  now_s_ += tick_s + skipped_s;
  gap_ = Longer(gap_, skipped_);
  counters_.skipped_ticks += skipped_;
  counters_.late_ticks += skipped_ > 0;
  bool leaks = false;
  if (sample.fresh) {
    leaks = AddLeak(sample, silent_s_ + since_last_s);
    silent_s_ = 0;
  } else {
    silent_s_ += since_last_s;
    ++counters_.stale_ticks;
  }
  // The most specific cause: an unplugged device is silent too.
  if (!sample.attached) {
    Latch(Fault::kUnplugged);
  } else if (!sample.driven) {
    Latch(Fault::kSwitchedOff);
  } else if (!DeviceAlive(sample)) {
    Interrupt(Fault::kStalled, silent_s_);
  }
  const bool watches = options_.faults_when_late && device_.has_motors();
  if (watches && DeviceAlive(sample)) WatchLateness(late_s, leaks);
}

void TickLoop::WatchLateness(double late_s, bool leaks) noexcept {
  if (skipped_ > 0 || leaks) {
    // The place of the twentieth one before this: if that is less than a second old, this is one too
    // many, for any window of a second.
    double& oldest = late_at_s_[late_count_ % late_at_s_.size()];
    if (late_count_ >= late_at_s_.size() && now_s_ - oldest < kLateWindow_s) {
      Latch(skipped_ > 0 ? Fault::kLateOften : Fault::kTooSlow);
    }
    oldest = last_late_s_ = now_s_;
    ++late_count_;
  }
  if (late_s >= kInterruptAfter_s) Interrupt(Fault::kLateOnce, late_s);
}

// `for_s`: how long it lasts by now.
void TickLoop::Interrupt(Fault fault, double for_s) noexcept {
  if (ride_ != Fault::kNone && now_s_ - ride_since_s_ < kRideFor_s) return;
  const bool is_short = ride_ == Fault::kNone && for_s < kRideFor_s;
  const bool is_single = now_s_ - ride_ended_s_ >= kRideAgain_s;
  if (this->fault() != Fault::kNone || !is_short || !is_single) return Latch(fault);
  ride_ = fault;
  ride_since_s_ = now_s_;
  ++counters_.interruptions;
}

void TickLoop::WatchRide(const DeviceSample& sample) noexcept {
  if (ride_ == Fault::kNone || !DeviceAlive(sample) || !sample.fresh) return;
  // Forces sent before it may still be under way (core.h).
  const double under_way_s = (core_.params().bus_delay_ticks + 1.0) / options_.rate_hz;
  if (now_s_ - ride_since_s_ < under_way_s - kRounding_s) return;
  ride_ = Fault::kNone;
  ride_ended_s_ = now_s_;
}

void TickLoop::WatchRecovery(const DeviceSample& sample) noexcept {
  const Fault present = fault();
  if (present == Fault::kNone) return;
  if (!DeviceAlive(sample)) alive_since_s_ = now_s_;
  const bool was_late =
      present == Fault::kLateOnce || present == Fault::kLateOften || present == Fault::kTooSlow;
  if (now_s_ - alive_since_s_ < kRecover_s || (was_late && now_s_ - last_late_s_ < kLateWindow_s)) {
    return;
  }
  fault_.store(Fault::kNone, std::memory_order_relaxed);
  soft_restart_ = true;
}

// max(0, Kc/2 - b/T_hold) |dx|^2, for a hold longer than a tick; and the torque's share. True if the
// hold leaks more than is lost in the device's cell.
bool TickLoop::AddLeak(const DeviceSample& sample, double hold_s) noexcept {
  const core::CoreParams& params = core_.params();
  double leak_j = 0;
  const bool had_force = has_last_ && fault() == Fault::kNone;
  if (had_force && options_.faults_when_late && hold_s > 1.0 / options_.rate_hz + kRounding_s) {
    double square = 0;
    for (size_t i = 0; i < 3; ++i) {
      double dx = (static_cast<double>(sample.counts[i]) - last_counts_[i]) *
                  params.resolution_nm[i] * 1e-9;
      square += dx * dx;
    }
    double rate = 0.5 * params.kc_mn_per_mm - options_.damping_n_s_per_m / hold_s;
    if (rate > 0) leak_j += rate * square;
    if (params.peak_torque_un_m > 0) {
      const dvec3 turned =
          haptics::ChordOfTurn(FromQuantised(sample.orientation), FromQuantised(last_orientation_));
      rate =
          0.5e-6 * params.rotational_kc_un_m_per_rad - options_.rotational_damping_n_m_s / hold_s;
      if (rate > 0) leak_j += rate * Dot(turned, turned);
    }
  }
  counters_.leak_j += leak_j;
  last_counts_ = sample.counts;
  last_orientation_ = sample.orientation;
  has_last_ = true;
  return leak_j > cell_energy_j_;
}

bool TickLoop::DeviceAlive(const DeviceSample& sample) const noexcept {
  return sample.attached && sample.driven && silent_s_ < kInterruptAfter_s - kRounding_s;
}

void TickLoop::WatchTurn(const DeviceSample& sample) noexcept {
  if (!sample.turned) return;
  has_last_ = false;  // the jump is no way over which a held force could leak
  soft_restart_ = true;
  AwaitStillness();
}

// A handpiece that is in its holder when the loop begins was not put down.
void TickLoop::WatchHolder(const DeviceSample& sample) noexcept {
  const bool down = (sample.buttons & kPutDown) != 0;
  if (down && holder_known_ && !put_down_) ++counters_.put_downs;
  if (down) AwaitStillness();
  put_down_ = down;
  holder_known_ = true;
}

void TickLoop::AwaitStillness() noexcept {
  still_ticks_ = 0;
  await_still_ = still_ticks_needed_ > 0;
}

void TickLoop::WatchStillness(const DeviceSample& sample) noexcept {
  if (!await_still_) return;
  bool still = DeviceAlive(sample);
  for (size_t i = 0; i < 3; ++i) {
    double moved = (static_cast<double>(sample.counts[i]) - still_at_[i]) *
                   core_.params().resolution_nm[i] * 1e-9;
    still = still && moved < kStillReach_m && -moved < kStillReach_m;
  }
  if (!still) {
    still_at_ = sample.counts;
    still_ticks_ = 0;
    return;
  }
  if (++still_ticks_ >= still_ticks_needed_) await_still_ = false;
}

void TickLoop::Latch(Fault fault) noexcept {
  const Fault before = fault_.exchange(fault, std::memory_order_relaxed);
  if (std::exchange(ride_, Fault::kNone) != Fault::kNone) --counters_.interruptions;
  if (before != Fault::kNone) return;  // the same fault by its present cause
  alive_since_s_ = now_s_;
  late_count_ = 0;
  AwaitStillness();
  record_due_ = record_count_ < kMaxRecords;
  ++counters_.faults;
}

void TickLoop::Remember(const DeviceSample& sample, const core::TickInput& input,
                        const dvec3& sent_n, double late_s) noexcept {
  constexpr size_t kTicks = FaultRecord::kTicks;
  history_[history_count_++ % kTicks] = {input,        sent_n,          late_s,
                                         sample.fresh, sample.attached, sample.driven};
  if (!record_due_) return;
  record_due_ = false;
  FaultRecord& record = records_[record_count_++];
  record.fault = fault();
  record.tick = counters_.ticks;
  record.count = history_count_ < kTicks ? static_cast<size_t>(history_count_) : kTicks;
  for (size_t i = 0; i < record.count; ++i) {
    record.ticks[i] = history_[(history_count_ - record.count + i) % kTicks];
  }
}

void TickLoop::Publish(const core::TickInput& input, const core::TickOutput& out) noexcept {
  ++counters_.ticks;
  if (out.flags & haptics::kPeakBounded) ++counters_.bounded_ticks;
  Snapshot snapshot;
  snapshot.counters = counters_;
  snapshot.anchor = out.anchor;
  snapshot.device = {core_.TipOf(input.counts), FromQuantised(input.orientation)};
  snapshot.pressed_n = out.pressed_n();
  snapshot.bur_speed_ratio = out.bur_speed_ratio;
  snapshot.removed = core_.removed();
  snapshot.input_flags = input.flags;
  snapshot.output_flags = out.flags;
  snapshot.fault = fault();
  snapshot.put_down = put_down_;
  snapshot.bur = static_cast<uint8_t>(core_.bur());
  snapshot.bur_waits = wanted_bur_.load(std::memory_order_relaxed) != core_.bur();
  snapshots_.Write(snapshot);
  if (observer_ != nullptr) observer_->OnTick(core_, snapshot);
}

}  // namespace enamel::station
