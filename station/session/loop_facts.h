#pragma once

#include <boost/json/fwd.hpp>

#include "station/devices/device.h"
#include "station/loop/tick_loop.h"

namespace enamel::station {

// What is to be known of a loop that has ended, kept with its attempt (schemas/loop_facts.md,
// version 1): its ticks and gaps, how punctual it was (with the histogram, one count per doubling
// of nanoseconds), what late ticks can have leaked, each fault with the ticks that led to it, and
// what the device's adapter counted. At most 100 kB as text. Not real-time. Requires:
// loop.finished(), or the tick's thread.
boost::json::object LoopFacts(const TickLoop& loop, const Device& device);

// {"count", "mean_us", "p50_us", "p99_us", "max_us", "ns": {"below_64": count, …}}; doublings
// without any are left out.
boost::json::object DurationFacts(const DurationHistogram& histogram);

}  // namespace enamel::station
