#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

// Which monitor is meant. Pure functions, any thread.
namespace enamel::station::render {

// Of the monitors with these names, the primary one first: the one that is named so, or has this
// number, 0 the first. None: there is no such one. A name goes before a number.
std::optional<size_t> FindMonitor(std::span<const std::string> names, std::string_view wanted);

// What a person reads when it is not there: "expected the monitor 'HDMI-2', found eDP-1, DP-1; …".
std::string MissingMonitorText(std::span<const std::string> names, std::string_view wanted);

}  // namespace enamel::station::render
