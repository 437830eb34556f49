#include "station/sdk/open_sdk_device.h"

#include <array>
#include <cctype>
#include <optional>

#include "common/scene/cell.h"
#include "station/sdk/buses.h"

namespace enamel::station::sdk {
namespace {

using OpenBus = Result<std::unique_ptr<PolledBus>> (*)();
using FindName = std::optional<std::string> (*)();

// A maker's library; its functions are null if this program was built without it.
struct Library {
  std::string_view choice, what;
  OpenBus open;
  FindName find;
};

constexpr std::array<Library, 2> kLibraries = {{
#ifdef ENAMEL_WITH_DHD
    {"dhd", "Force Dimension's SDK", OpenForceDimension, FindForceDimension},
#else
    {"dhd", "Force Dimension's SDK", nullptr, nullptr},
#endif
#ifdef ENAMEL_WITH_OPENHAPTICS
    {"openhaptics", "OpenHaptics", OpenOpenHaptics, FindOpenHaptics},
#else
    {"openhaptics", "OpenHaptics", nullptr, nullptr},
#endif
}};

const Library* Find(std::string_view choice) {
  for (const Library& library : kLibraries) {
    if (library.choice == choice) return &library;
  }
  return nullptr;
}

Result<std::unique_ptr<Device>> Open(const Library& library, const hid::DeviceChoice& choice,
                                     const scene::DeviceProfile& profile) {
  if (library.open == nullptr) {
    return Status(Code::kUnavailable,
                  "this program was built without " + std::string(library.what) + ", which '" +
                      std::string(library.choice) +
                      "' needs: install the maker's SDK and build again (station/sdk/README.md)",
                  "device");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto bus, library.open());
  const double resolution_m = scene::CountNm(profile) * 1e-9;
  return std::unique_ptr<Device>(
      // A maker's calls may wait for the bus: a thread polls, the tick takes the latest.
      std::make_unique<PolledDevice>(std::move(bus), resolution_m, choice.thread_setup));
}

}  // namespace

std::vector<SdkDevice> ListSdkDevices() {
  std::vector<SdkDevice> out;
  for (const Library& library : kLibraries) {
    if (library.find == nullptr) continue;
    if (auto name = library.find()) {
      out.push_back({std::string(library.choice), *name, ProfileNameOf(*name)});
    }
  }
  return out;
}

std::vector<std::string> BuiltIn() {
  std::vector<std::string> out;
  for (const Library& library : kLibraries) {
    if (library.open != nullptr) out.emplace_back(library.choice);
  }
  return out;
}

std::string ProfileNameOf(std::string_view model) {
  std::string out;
  bool word_ended = false;
  for (unsigned char c : model) {
    if (std::isalnum(c) != 0 && c < 0x80) {
      if (word_ended && !out.empty()) out += '_';
      word_ended = false;
      out += static_cast<char>(std::tolower(c));
    } else if (c == ' ' || c == '_' || c == '-') {
      // Any other sign joins: "omega.3" is one word.
      word_ended = true;
    }
  }
  return out;
}

bool IsSdkDevice(std::string_view choice) { return Find(choice) != nullptr; }

Result<std::unique_ptr<Device>> OpenChosenDevice(const hid::DeviceChoice& choice,
                                                 const scene::DeviceProfile& profile,
                                                 double tick_s) {
  const Library* library = Find(choice.device);
  if (library == nullptr) return hid::OpenDevice(choice, profile, tick_s);
  auto device = Open(*library, choice, profile);
  if (!device.ok()) return device;
  return hid::WithPedal(std::move(*device), choice.pedal);
}

}  // namespace enamel::station::sdk
