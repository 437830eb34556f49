#include "station/sdk/open_sdk_device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "station/sdk/buses.h"

namespace enamel::station::sdk {
namespace {

using OpenBus = Result<std::unique_ptr<PolledBus>> (*)(const BusChoice&);
using FindDevices = std::vector<SdkDevice> (*)();

struct Driver {
  std::string_view choice;
  OpenBus open;
  FindDevices find;
  std::span<const DeviceNode> nodes;  // the device files that it opens, or its library does
  bool answers = false;               // as PolledBus::answers
  Status (*library)() = nullptr;  // whether the maker's library can be loaded; null: it needs none
};

// Of BusChoice::for_hand, for a device that comes back in the middle of an attempt.
constexpr std::chrono::milliseconds kHandAgain{1'000};

constexpr std::array kDrivers = {
    Driver{"dhd", OpenForceDimension, FindForceDimension, kForceDimensionNodes, false,
           LoadForceDimension},
    Driver{"openhaptics", OpenOpenHaptics, FindOpenHaptics, kOpenHapticsNodes, false,
           LoadOpenHaptics},
    Driver{"woodenhaptics", OpenWoodenHaptics, FindWoodenHaptics, kMbedNodes, true},
    Driver{"polhem", OpenPolhem, FindPolhem, kMbedNodes, true},
    Driver{"polhem_serial", OpenPolhemSerial, FindPolhemSerial, kPolhemSerialNodes, true},
    Driver{"inverse3", OpenInverse3, FindInverse3, {}, true},
    Driver{"falcon", OpenFalcon, FindFalcon, kFalconNodes, true},
};

std::string_view NameIn(std::string_view choice) { return choice.substr(0, choice.find(':')); }

const Driver* Find(std::string_view choice) {
  const auto* found = std::ranges::find(kDrivers, NameIn(choice), &Driver::choice);
  return found == kDrivers.end() ? nullptr : found;
}

Result<std::unique_ptr<Device>> Open(const Driver& driver, const hid::DeviceChoice& choice,
                                     const scene::DeviceProfile& profile) {
  BusChoice wanted;
  if (choice.device.size() > driver.choice.size())
    wanted.address = choice.device.substr(driver.choice.size() + 1);
  wanted.peak_n = static_cast<double>(profile.peak_force_mn.value) * 1e-3;
  wanted.profile = profile.name;
  wanted.has_pedal = !choice.pedal.empty();
  wanted.reach_m = static_cast<double>(profile.workspace_radius_um.value) * 1e-6;
  ENAMEL_ASSIGN_OR_RETURN(auto bus, driver.open(wanted));
  // Tried again and again, so that no try need wait long.
  wanted.for_hand = kHandAgain;
  // With two attached the other may be listed first by then.
  wanted.unit = bus->Unit();
  const double resolution_m = scene::CountNm(profile) * 1e-9;
  // A bus may wait: a thread polls, the tick takes the latest.
  return std::unique_ptr<Device>(
      std::make_unique<PolledDevice>(std::move(bus), resolution_m, choice.thread_setup,
                                     [open = driver.open, wanted] { return open(wanted); }));
}

}  // namespace

std::vector<SdkDevice> ListSdkDevices() {
  std::vector<SdkDevice> out;
  for (const Driver& driver : kDrivers) {
    for (SdkDevice& found : driver.find()) {
      found.choice = driver.choice;
      found.answers = driver.answers;
      out.push_back(std::move(found));
    }
  }
  return out;
}

std::string AskedForText(const SdkDevice& device) {
  const auto profile = scene::FindProfile(device.profile);
  if (!profile.ok()) return {};
  std::string members;
  for (const std::string& member : scene::AskedFor(*profile)) {
    members += (members.empty() ? "" : ", ") + member;
  }
  if (members.empty()) return {};
  return device.name + ": profile " + device.profile + " asks for " + members +
         ", which nobody published: 'enamel-station calibrate --device " + device.choice +
         " --out FILE' measures what can be measured";
}

std::vector<std::string> Drivers() {
  std::vector<std::string> out;
  for (const Driver& driver : kDrivers) out.emplace_back(driver.choice);
  return out;
}

std::span<const DeviceNode> NodesOf(std::string_view choice) {
  const Driver* driver = Find(choice);
  return driver == nullptr ? std::span<const DeviceNode>() : driver->nodes;
}

Status CheckLibrary(std::string_view choice) {
  const Driver* driver = Find(choice);
  return driver == nullptr || driver->library == nullptr ? Status::Ok() : driver->library();
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
  const Driver* driver = Find(choice.device);
  if (driver == nullptr) return hid::OpenDevice(choice, profile, tick_s);
  auto device = Open(*driver, choice, profile);
  ENAMEL_RETURN_IF_ERROR(device.status());
  return hid::WithPedal(std::move(*device), choice.pedal);
}

}  // namespace enamel::station::sdk
