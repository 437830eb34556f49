#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "tests/load/arguments.h"

// A run's findings, by name.
namespace enamel::load {

// Reorders the report's lists of durations.
boost::json::object Facts(const Arguments& a, LoadReport& report);
std::string ForPeople(const boost::json::value& value);
// Whether everything sent is there once.
bool Sound(const LoadReport& report);

}  // namespace enamel::load
