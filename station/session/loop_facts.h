#pragma once

#include <boost/json/fwd.hpp>
#include <cstddef>
#include <span>
#include <string>

#include "station/devices/device.h"
#include "station/loop/tick_loop.h"

namespace enamel::station {

// Facts of a loop that has ended, kept with its attempt (schemas/loop_facts.md, version 1): ticks
// and gaps, punctuality (with the histogram, one count per doubling of nanoseconds), the largest
// possible leak of late ticks, each fault with the ticks that led to it, and the counters of the
// device's adapter. At most kLoopFactsBytes as text. Not real-time. Requires: loop.finished(), or
// the tick's thread.
inline constexpr int kLoopFactsVersion = 1;
inline constexpr size_t kLoopFactsBytes = 150'000;
boost::json::object LoopFacts(const TickLoop& loop, const Device& device);

// "13844 ticks, 1 late, 3 in gaps, 0 interruptions, 0 faults": as the log and the operator's panel say it.
std::string CountsText(const LoopCounters& counters);

// Member `faults`: each fault with the ticks that led to it.
boost::json::array FaultFacts(std::span<const FaultRecord> records);

// {"count", "mean_us", "p50_us", "p99_us", "max_us", "ns": {"below_64": count, …}}; empty doublings
// are left out.
boost::json::object DurationFacts(const DurationHistogram& histogram);

}  // namespace enamel::station
