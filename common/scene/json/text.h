#pragma once

#include <boost/json/value.hpp>
#include <string>

namespace enamel::scene {

// Canonical text of a JSON value: members in the order they were inserted, two-space indent, arrays
// of scalars on one line, numbers in their shortest form that reads back to the same value, '\n' at
// the end. Equal values give equal bytes. Requires: all numbers finite.
std::string CanonicalText(const boost::json::value& value);

}  // namespace enamel::scene
