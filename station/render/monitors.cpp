#include "station/render/monitors.h"

#include <algorithm>
#include <charconv>

namespace enamel::station::render {

std::optional<size_t> FindMonitor(std::span<const std::string> names, std::string_view wanted) {
  const auto named = std::ranges::find(names, wanted);
  if (named != names.end()) return static_cast<size_t>(named - names.begin());
  size_t number = 0;
  const char* end = wanted.data() + wanted.size();
  const auto [stopped, error] = std::from_chars(wanted.data(), end, number);
  if (error != std::errc() || stopped != end || number >= names.size()) return std::nullopt;
  return number;
}

std::string MissingMonitorText(std::span<const std::string> names, std::string_view wanted) {
  if (names.empty()) return "no monitor is attached; the window is shown once one is";
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return "expected the monitor '" + std::string(wanted) + "', found " + all +
         "; the window is on " + names[0] +
         " until it is attached; --monitor or the setting "
         "'monitor' chooses another";
}

}  // namespace enamel::station::render
