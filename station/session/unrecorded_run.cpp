#include "station/session/unrecorded_run.h"

#include <chrono>
#include <utility>

#include "station/loop/realtime.h"

namespace enamel::station {
namespace {

constexpr std::chrono::milliseconds kDropEvery{2};
constexpr size_t kDroppedRing = 4000;

TickLoopOptions OptionsAfter(const core::Core& core, const PreparedAttempt& prepared,
                             const AttemptOptions& options) {
  TickLoopOptions out = LoopOptionsOf(prepared, options);
  out.ticks_before = core.ticks();
  // How long ago it ended does not matter here; that the hand may have moved does.
  out.first_gap_ticks = core.ticks() > 0 ? 1 : 0;
  return out;
}

}  // namespace

UnrecordedRun::UnrecordedRun(std::unique_ptr<core::Core> core, const PreparedAttempt& prepared,
                             Device& device, const AttemptOptions& options)
    : observer_(options.observer),
      tick_s_(1.0 / prepared.header.params.rate_hz),
      core_(std::move(core)),
      ring_(kDroppedRing),
      loop_(device, *core_, ring_, OptionsAfter(*core_, prepared, options), this),
      dropper_([this] { Drop(); }),
      ticker_([this, cpu = options.cpu] {
        // If refused, the attempt's own request reports it.
        lacks_realtime_ = !RequestRealtime({cpu}).steady();
        loop_.Run();
      }) {}

void UnrecordedRun::End() {
  loop_.RequestStop();
  if (ticker_.joinable()) ticker_.join();
  if (dropper_.joinable()) dropper_.join();
}

void UnrecordedRun::OnTick(const core::Core& core, const Snapshot& snapshot) noexcept {
  const auto relaxed = std::memory_order_relaxed;
  // The only writer.
  if ((snapshot.input_flags & core::kBurOn) != 0) {
    turning_ticks_.store(turning_ticks_.load(relaxed) + 1, relaxed);
  }
  const double force_n = glm::length(snapshot.pressed_n);
  if (force_n > peak_force_n_.load(relaxed)) peak_force_n_.store(force_n, relaxed);
  if (observer_ != nullptr) observer_->OnTick(core, snapshot);
}

void UnrecordedRun::Drop() {
  Sample sample;
  while (!loop_.finished()) {
    while (ring_.Pop(sample)) {
    }
    std::this_thread::sleep_for(kDropEvery);
  }
}

UnrecordedRun::Found UnrecordedRun::found() {
  const LoopCounters& counters = snapshot().counters;
  return {counters.ticks, counters.late_ticks, counters.faults,
          static_cast<double>(turning_ticks_.load(std::memory_order_relaxed)) * tick_s_,
          peak_force_n_.load(std::memory_order_relaxed)};
}

}  // namespace enamel::station
