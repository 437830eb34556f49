#pragma once

#include <boost/json/fwd.hpp>
#include <cstddef>
#include <span>

#include "station/devices/device.h"
#include "station/loop/tick_loop.h"

namespace enamel::station {

// What is to be known of a loop that has ended, kept with its attempt (schemas/loop_facts.md,
// version 1): its ticks and gaps, how punctual it was (with the histogram, one count per doubling
// of nanoseconds), what late ticks can have leaked, each fault with the ticks that led to it, and
// what the device's adapter counted. At most kLoopFactsBytes as text. Not real-time. Requires:
// loop.finished(), or the tick's thread.
inline constexpr int kLoopFactsVersion = 1;
inline constexpr size_t kLoopFactsBytes = 150'000;
boost::json::object LoopFacts(const TickLoop& loop, const Device& device);

// Its `faults`: each with the ticks that led to it.
boost::json::array FaultFacts(std::span<const FaultRecord> records);

// {"count", "mean_us", "p50_us", "p99_us", "max_us", "ns": {"below_64": count, …}}; doublings
// without any are left out.
boost::json::object DurationFacts(const DurationHistogram& histogram);

}  // namespace enamel::station
