#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "tests/load/arguments.h"

// What a run was found to do, by name.
namespace enamel::load {

// Takes the report's lists of durations apart.
boost::json::object Facts(const Arguments& a, LoadReport& report);
std::string ForPeople(const boost::json::value& value);
// All that was sent is there once.
bool Sound(const LoadReport& report);

}  // namespace enamel::load
