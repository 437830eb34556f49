#include "station/hid/open_device.h"

#include <cmath>

#include "common/scene/cell.h"
#include "station/hid/axis_map.h"
#include "station/hid/foot_pedal.h"
#include "station/hid/haptic_board.h"
#include "station/hid/space_mouse.h"

namespace enamel::station::hid {
namespace {

constexpr std::string_view kBoardName = "hid", kMouseName = "spacemouse";

// The part after "hid" or "spacemouse": ids, or nothing for any.
Result<HidMatch> MatchAfter(std::string_view choice, std::string_view kind) {
  std::string_view rest = choice.substr(kind.size());
  if (rest.empty()) return HidMatch{};
  return ParseHidMatch(rest.substr(1));
}

bool Names(std::string_view choice, std::string_view kind) {
  return choice == kind || (choice.starts_with(kind) && choice[kind.size()] == ':');
}

Result<std::unique_ptr<Device>> OpenBoard(const DeviceChoice& choice,
                                          const scene::DeviceProfile& profile, double tick_s) {
  HapticBoardSettings settings;
  ENAMEL_ASSIGN_OR_RETURN(auto match, MatchAfter(choice.device, kBoardName));
  ENAMEL_ASSIGN_OR_RETURN(auto axes, ParseAxisMap(choice.axes));
  settings.match = match;
  settings.axes = axes;
  settings.watchdog_ms = choice.watchdog_ms;
  settings.thread_setup = choice.thread_setup;
  ENAMEL_ASSIGN_OR_RETURN(auto board, HapticBoard::Open(settings));
  ENAMEL_RETURN_IF_ERROR(
      CheckBoard(board->feature(), profile, static_cast<uint32_t>(std::lround(1 / tick_s))));
  return std::unique_ptr<Device>(std::move(board));
}

Result<std::unique_ptr<Device>> OpenMouse(const DeviceChoice& choice,
                                          const scene::DeviceProfile& profile, double tick_s) {
  SpaceMouseSettings settings;
  ENAMEL_ASSIGN_OR_RETURN(auto match, MatchAfter(choice.device, kMouseName));
  settings.match = match;
  settings.match.usage_page = kMultiAxisPage;
  settings.match.usage = kMultiAxisUsage;
  settings.reach_m = static_cast<double>(profile.workspace_radius_um.value) * 1e-6;
  const double resolution_m = scene::CountNm(profile) * 1e-9;
  ENAMEL_ASSIGN_OR_RETURN(auto mouse, SpaceMouse::Open(settings, resolution_m, tick_s));
  return std::unique_ptr<Device>(std::move(mouse));
}

}  // namespace

HidKind Recognise(const HidInfo& info) {
  if (info.usage_page == kBoardUsagePage && info.usage == kBoardUsage) return HidKind::kHapticBoard;
  // Logitech's and 3Dconnexion's own: other makers' devices may have the same usage.
  bool maker = info.vendor == 0x046d || info.vendor == 0x256f;
  if (maker && info.usage_page == kMultiAxisPage && info.usage == kMultiAxisUsage) {
    return HidKind::kSpaceMouse;
  }
  if (PedalSettings{}.match.Fits(info)) return HidKind::kFootPedal;
  return HidKind::kOther;
}

const char* HidKindText(HidKind kind) {
  switch (kind) {
    case HidKind::kHapticBoard:
      return "haptic board";
    case HidKind::kSpaceMouse:
      return "6-DoF mouse, no force";
    case HidKind::kFootPedal:
      return "foot pedal";
    case HidKind::kOther:
      return "nothing known here";
  }
  return "";
}

std::string DeviceNameOf(const HidInfo& info) {
  std::string ids = HidMatch{info.vendor, info.product, info.serial, 0, 0}.Text();
  switch (Recognise(info)) {
    case HidKind::kHapticBoard:
      return std::string(kBoardName) + ":" + ids;
    case HidKind::kSpaceMouse:
      return std::string(kMouseName) + ":" + ids;
    case HidKind::kFootPedal:
    case HidKind::kOther:
      return ids;
  }
  return ids;
}

Status WhyNotUsable(const HidInfo& info) { return WhyNotOpenable(info.path); }

Result<std::unique_ptr<Device>> OpenDevice(const DeviceChoice& choice,
                                           const scene::DeviceProfile& profile, double tick_s) {
  Result<std::unique_ptr<Device>> device =
      Names(choice.device, kBoardName) ? OpenBoard(choice, profile, tick_s)
      : Names(choice.device, kMouseName)
          ? OpenMouse(choice, profile, tick_s)
          : Status(Code::kInvalidInput,
                   "expected hid or spacemouse, with :VENDOR:PRODUCT "
                   "where there are several, or a driver; found '" +
                       choice.device +
                       "'. 'enamel-station devices' lists what is "
                       "attached",
                   "device");
  ENAMEL_RETURN_IF_ERROR(device.status());
  return WithPedal(std::move(*device), choice.pedal);
}

Result<std::unique_ptr<Device>> WithPedal(std::unique_ptr<Device> device,
                                          const std::string& pedal) {
  if (pedal.empty()) return device;
  ENAMEL_ASSIGN_OR_RETURN(auto settings, ParsePedal(pedal));
  ENAMEL_ASSIGN_OR_RETURN(auto opened, FootPedal::Open(settings));
  return std::unique_ptr<Device>(
      std::make_unique<PedalledDevice>(std::move(device), std::move(opened)));
}

Result<FeatureReport> AskBoard(const HidInfo& info) {
  ENAMEL_ASSIGN_OR_RETURN(auto port, HidPort::Open(info.path));
  return AskFeature(*port);
}

}  // namespace enamel::station::hid
