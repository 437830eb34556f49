#include "server/auth/device_name.h"

namespace enamel::server::auth {
namespace {

constexpr size_t kMaxRead = 512;

struct Known {
  std::string_view mark, name;
};
// Browsers name those that they are to be taken for, so the first that is found counts.
constexpr Known kBrowsers[] = {{"Edg/", "Edge"},
                               {"EdgA/", "Edge"},
                               {"EdgiOS/", "Edge"},
                               {"OPR/", "Opera"},
                               {"SamsungBrowser/", "Samsung Internet"},
                               {"Vivaldi/", "Vivaldi"},
                               {"FxiOS/", "Firefox"},
                               {"Firefox/", "Firefox"},
                               {"CriOS/", "Chrome"},
                               {"Chrome/", "Chrome"},
                               {"Safari/", "Safari"},
                               {"curl/", "curl"}};
constexpr Known kSystems[] = {{"Android", "Android"}, {"iPhone", "iPhone"}, {"iPad", "iPad"},
                              {"Windows", "Windows"}, {"CrOS", "ChromeOS"}, {"Macintosh", "macOS"},
                              {"Linux", "Linux"}};

template <size_t n>
std::string_view FirstOf(const Known (&known)[n], std::string_view text) {
  for (const Known& one : known) {
    if (text.find(one.mark) != std::string_view::npos) return one.name;
  }
  return {};
}

}  // namespace

std::string DeviceName(std::string_view user_agent) {
  const std::string_view read = user_agent.substr(0, kMaxRead);
  const std::string_view browser = FirstOf(kBrowsers, read), system = FirstOf(kSystems, read);
  if (system.empty()) return std::string(browser);
  return std::string(browser.empty() ? "a browser" : browser) + " on " + std::string(system);
}

}  // namespace enamel::server::auth
