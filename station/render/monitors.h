#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

// The monitor that a setting names. Pure functions, any thread.
namespace enamel::station::render {

// Index of the monitor with this name, or else with this number, 0 the first. `names` begin with the
// primary one. None: no monitor has that name or number.
std::optional<size_t> FindMonitor(std::span<const std::string> names, std::string_view wanted);

// The line of the log for that: "expected the monitor 'HDMI-2', found eDP-1, DP-1; …".
std::string MissingMonitorText(std::span<const std::string> names, std::string_view wanted);

}  // namespace enamel::station::render
