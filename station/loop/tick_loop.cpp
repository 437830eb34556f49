#include "station/loop/tick_loop.h"

#include <time.h>

namespace enamel::station {
namespace {

constexpr double kFaultAfter_s = 5e-3;
constexpr int kLateTicksPerWindow = 20;
constexpr double kLateWindow_s = 1.0;
constexpr int64_t kSecond_ns = 1'000'000'000;
// How long a lockstep loop waits before it looks at a full ring again.
constexpr int64_t kBackPressure_ns = 100'000;

int64_t Now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond_ns + t.tv_nsec;
}

void SleepUntil(int64_t due_ns) noexcept {
  timespec t{due_ns / kSecond_ns, due_ns % kSecond_ns};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

}  // namespace

TickLoop::TickLoop(Device& device, core::Core& core, SampleRing& ring,
                   const TickLoopOptions& options, TickObserver* observer)
    : device_(device), core_(core), ring_(ring), options_(options), observer_(observer) {
  ENAMEL_CHECK(options_.rate_hz > 0);
}

void TickLoop::Run() noexcept {
  const int64_t period_ns = kSecond_ns / options_.rate_hz;
  int64_t due_ns = Now_ns();
  while (!stop_.load(std::memory_order_relaxed)) {
    if (options_.lockstep) {
      if (ring_.Full()) {
        SleepUntil(Now_ns() + kBackPressure_ns);
        continue;
      }
      if (Tick()) break;
      continue;
    }
    due_ns += period_ns;
    SleepUntil(due_ns);
    int64_t late_ns = Now_ns() - due_ns;
    if (Tick(static_cast<double>(late_ns) * 1e-9)) break;
    // Periods that passed meanwhile are not made up for: the hand has moved on.
    if (late_ns > period_ns) due_ns += late_ns / period_ns * period_ns;
  }
  device_.SendForce(dvec3(0));
  finished_.store(true, std::memory_order_release);
}

bool TickLoop::Tick(double late_s) noexcept {
  DeviceSample sample = device_.ReadSample();
  WatchTime(sample, late_s);
  if (ring_.Full()) {
    // What cannot be recorded is not stepped: no force, no cut, a declared gap.
    ++gap_;
    ++counters_.gap_ticks;
    device_.SendForce(dvec3(0));
    return (sample.buttons & kFinish) != 0;
  }
  core::TickInput input = InputOf(sample);
  core::TickOutput out = core_.Step(input);  // finite check, law, bound, finite check (coupling.h)
  device_.SendForce(out.force_sent_n);
  ring_.Push({{input, out.witness}, core_.state_hash()});
  if (out.flags & core::kReserveExhausted) Latch(Fault::kReserve);
  Publish(input, out);
  device_.ShowBur(out.anchor.tip_m);
  return (sample.buttons & kFinish) != 0;
}

core::TickInput TickLoop::InputOf(const DeviceSample& sample) noexcept {
  bool pedal = (sample.buttons & kPedal) != 0;
  if (fault_ != Fault::kNone) {
    if (!pedal) pedal_released_ = true;
    if (pedal && pedal_released_) {
      fault_ = Fault::kNone;
      soft_restart_ = true;
    }
  }
  core::TickInput input;
  input.counts = sample.counts;
  input.orientation = sample.orientation;
  input.bur_speed_krpm = sample.bur_speed_krpm;
  input.gap_ticks = gap_;
  gap_ = 0;
  if (pedal) input.flags |= core::kBurOn;
  if (late_) input.flags |= core::kLateTick;
  if (fault_ != Fault::kNone) input.flags |= core::kFaulted;
  if (soft_restart_) input.flags |= core::kSoftRestart;
  soft_restart_ = false;
  return input;
}

void TickLoop::WatchTime(const DeviceSample& sample, double late_s) noexcept {
  double tick_s = 1.0 / options_.rate_hz;
  late_ = late_s >= tick_s;
  if (late_) ++counters_.late_ticks;
  silent_s_ = sample.fresh ? 0 : silent_s_ + tick_s + late_s;
  if (silent_s_ >= kFaultAfter_s) Latch(Fault::kStalled);
  if (!options_.faults_when_late) return;
  late_window_s_ += tick_s;
  if (late_window_s_ >= kLateWindow_s) {
    late_window_s_ = 0;
    late_in_window_ = 0;
  }
  if (late_ && ++late_in_window_ > kLateTicksPerWindow) Latch(Fault::kLateOften);
  if (late_s >= kFaultAfter_s) Latch(Fault::kLateOnce);
}

void TickLoop::Latch(Fault fault) noexcept {
  if (fault_ != Fault::kNone) return;
  fault_ = fault;
  pedal_released_ = false;
  ++counters_.faults;
}

void TickLoop::Publish(const core::TickInput& input, const core::TickOutput& out) noexcept {
  ++counters_.ticks;
  if (out.flags & haptics::kPeakBounded) ++counters_.bounded_ticks;
  Snapshot snapshot;
  snapshot.counters = counters_;
  snapshot.anchor = out.anchor;
  snapshot.device = {core_.TipOf(input.counts), FromQuantised(input.orientation)};
  snapshot.force_sent_n = out.force_sent_n;
  snapshot.removed = core_.removed();
  snapshot.input_flags = input.flags;
  snapshot.output_flags = out.flags;
  snapshots_.Write(snapshot);
  if (observer_ != nullptr) observer_->OnTick(core_, snapshot);
}

}  // namespace enamel::station
