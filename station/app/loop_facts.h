#pragma once

#include <boost/json/fwd.hpp>

#include "station/devices/device.h"
#include "station/loop/tick_loop.h"

namespace enamel::station {

// What is to be known of a loop that has ended: how punctual it was (with the histogram, one count
// per doubling of nanoseconds), what late ticks can have leaked, each fault with the ticks that led
// to it, and what the device's adapter counted. Requires: loop.finished().
boost::json::object LoopFacts(const TickLoop& loop, const LoopCounters& counters,
                              const Device& device);

}  // namespace enamel::station
