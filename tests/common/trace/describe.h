#pragma once

#include <boost/json.hpp>

#include "common/trace/trace.h"

// Content of each structure as the JSON of schemas/golden says it.
namespace enamel::trace {

boost::json::object Describe(const Ticket& ticket);
boost::json::object Describe(const Header& header);
// Head, hash, signature, unpacked payload and every tick.
boost::json::object Describe(const Chunk& chunk);
boost::json::object Describe(const Seal& seal);
// Header, seal, and per chunk its head and hash.
boost::json::object Describe(const TraceFile& file);

}  // namespace enamel::trace
