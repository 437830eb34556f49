#include "station/app/devices.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>

#include "common/program/output.h"
#include "station/devices/operators.h"
#include "station/hid/haptic_board.h"
#include "station/hid/open_device.h"
#include "station/sdk/open_sdk_device.h"
#include "station/session/device_delay.h"

namespace enamel::station {
namespace {

using hid::HidInfo;
using hid::HidKind;

// "profile phantom_desktop, 3 axes, 0.010 mm, 7.9 N", or why it is unknown.
std::string BoardText(const HidInfo& info, boost::json::object& out) {
  // Only asks for its description: no force, no motion.
  auto board = hid::AskBoard(info);
  if (!board.ok()) return board.status().message();
  out["profile"] = board->profile;
  out["axes"] = board->axes;
  out["resolution_nm"] = board->resolution_nm[0];
  out["peak_force_mn"] = board->peak_force_mn[0];
  char text[160];
  std::snprintf(text, sizeof text, "%s: profile %s, %d axes, cells of %.3f mm, up to %.1f N",
                board->name.c_str(),
                board->profile.empty() ? "none ('calibrate' proposes one)" : board->profile.c_str(),
                board->axes, board->resolution_nm[0] * 1e-6, board->peak_force_mn[0] * 1e-3);
  std::string all = text;
  if (board->runs_spring()) {
    out["spring_kc_mn_per_mm"] = board->spring_kc_mn_per_mm;
    out["spring_rate_hz"] = board->spring_rate_hz;
    std::snprintf(text, sizeof text, ", runs a spring of %.2f N/mm at %d Hz",
                  board->spring_kc_mn_per_mm * 1e-3, board->spring_rate_hz);
    all += text;
  }
  return all;
}

boost::json::object Show(const HidInfo& info, const std::filesystem::path& data) {
  HidKind kind = hid::Recognise(info);
  boost::json::object out{{"name", hid::DeviceNameOf(info)},
                          {"taken_for", hid::HidKindText(kind)},
                          {"product", info.name},
                          {"path", info.path},
                          {"usable", hid::WhyNotUsable(info).ok()}};
  std::printf("%-28s %-22s %s\n", hid::DeviceNameOf(info).c_str(), hid::HidKindText(kind),
              info.name.c_str());
  if (const Status refused = hid::WhyNotUsable(info); !refused.ok()) {
    std::printf("    %s\n", refused.message().c_str());
  } else if (kind == HidKind::kHapticBoard) {
    std::printf("    %s\n", BoardText(info, out).c_str());
    const auto delay = DelayKnownHere(data, hid::UnitOf(info));
    out["delay_ticks"] = delay.ticks;
    out["delay_measured"] = delay.from != scene::DelayUsed::From::kAssumed;
    std::printf("    %s\n", DelayText(delay, hid::DeviceNameOf(info)).c_str());
  }
  return out;
}

void ShowSdk(boost::json::array& listed, const std::filesystem::path& data) {
  std::printf("\nDrivers for devices that can be bought:\n");
  const auto attached = sdk::ListSdkDevices();
  for (const std::string& choice : sdk::Drivers()) {
    if (std::ranges::find(attached, choice, &sdk::SdkDevice::choice) == attached.end()) {
      const Status library = sdk::CheckLibrary(choice);
      std::printf("%-28s finds no device\n", choice.c_str());
      if (!library.ok()) std::printf("    %s\n", library.message().c_str());
    }
  }
  for (const sdk::SdkDevice& device : attached) {
    std::printf("%-28s %s%s: profile %s\n", device.choice.c_str(), device.name.c_str(),
                device.ids.empty() ? "" : (" " + device.ids).c_str(), device.profile.c_str());
    if (!device.problem.ok()) std::printf("    %s\n", device.problem.message().c_str());
    const std::string asked = sdk::AskedForText(device);
    if (!asked.empty()) std::printf("    %s\n", asked.c_str());
    // A measurement belongs to a unit: without a name for it there is none.
    const auto delay = DelayKnownHere(data, device.unit);
    std::printf("    %s\n", DelayText(delay, device.name).c_str());
    listed.push_back(
        boost::json::object{{"name", device.choice},
                            {"taken_for", "device with a driver"},
                            {"product", device.name},
                            {"ids", device.ids},
                            {"profile", device.profile},
                            {"delay_ticks", delay.ticks},
                            {"delay_measured", delay.from != scene::DelayUsed::From::kAssumed},
                            {"usable", device.problem.ok()}});
  }
}

void ShowBuiltIn() {
  std::printf("\nAlways there:\n");
  std::printf("%-28s %s\n", "pointer",
              "mouse and keyboard in the window; profile pointer, no force");
  std::printf("%-28s %s\n", "simulated",
              "with any profile ('profiles' lists them), held by one of:");
  for (const OperatorPreset& p : OperatorPresets()) {
    std::printf("    %-24s %s\n", std::string(p.name).c_str(), std::string(p.summary).c_str());
  }
}

}  // namespace

Status ListDevices(const DevicesCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  boost::json::array listed;
  size_t unknown = 0;
  std::printf("Attached (HID):\n");
  for (const HidInfo& info : hid::ListHid()) {
    // Keyboards, mice and webcams are HID too; listing them all would hide the device the person
    // needs.
    if (hid::Recognise(info) == HidKind::kOther && !options.all) {
      ++unknown;
      continue;
    }
    listed.push_back(Show(info, options.data));
  }
  if (listed.empty()) std::printf("    no haptic board, 6-DoF mouse or foot pedal\n");
  if (unknown > 0) {
    std::printf(
        "    and %zu that are not known here (--all lists them; a pedal among them can "
        "be named with --pedal VENDOR:PRODUCT)\n",
        unknown);
  }
  ShowSdk(listed, options.data);
  ShowBuiltIn();
  return program::WriteJsonFile(options.json, {{"attached", listed}});
}

}  // namespace enamel::station
