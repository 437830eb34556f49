#include "station/app/measured_device.h"

#include <time.h>

#include <algorithm>
#include <ratio>

#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "station/hid/haptic_board.h"
#include "station/hid/open_device.h"
#include "station/loop/realtime.h"
#include "station/sdk/open_sdk_device.h"

namespace enamel::station {
namespace {

constexpr const char* kOfBoard = "the device's own (HID feature report)";

// A device that does not say what it is: its profile does.
Result<MeasuredDevice> OpenOfTable(const std::string& address, std::string name, int rate_hz) {
  for (const sdk::SdkDevice& found : sdk::ListSdkDevices()) {
    const bool chosen = address.substr(0, address.find(':')) == found.choice;
    if (chosen && name.empty()) name = found.profile;
  }
  if (name.empty()) {
    return Status(
        Code::kNotFound,
        "'" + address +
            "' is not attached, so that its profile is not known: plug it in, or name the "
            "profile with --profile",
        "device");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::FindProfile(name));
  hid::DeviceChoice choice;
  choice.device = address;
  choice.thread_setup = [] { (void)RequestRealtime(); };
  ENAMEL_ASSIGN_OR_RETURN(auto device, sdk::OpenChosenDevice(choice, profile, 1.0 / rate_hz));
  MeasuredDevice out;
  out.count_m.fill(scene::CountNm(profile) * 1e-9);
  out.profile = std::move(profile);
  out.address = address + " " + device->Name();
  out.device = std::move(device);
  out.real = true;
  return out;
}

}  // namespace

Result<MeasuredDevice> OpenToMeasure(const std::string& choice, const std::string& profile_name,
                                     int rate_hz) {
  if (sdk::IsSdkDevice(choice)) return OpenOfTable(choice, profile_name, rate_hz);
  hid::HapticBoardSettings settings;
  size_t colon = choice.find(':');
  if (choice.substr(0, colon) != "hid") {
    return Status(
        Code::kInvalidInput,
        "expected hid, hid:VENDOR:PRODUCT, a driver that 'enamel-station devices' lists, or "
        "simulated:PROFILE, found '" +
            choice + "': only devices with motors can be measured",
        "device");
  }
  if (colon != std::string::npos) {
    ENAMEL_ASSIGN_OR_RETURN(auto match,
                            hid::ParseHidMatch(std::string_view(choice).substr(colon + 1)));
    settings.match = match;
  }
  settings.thread_setup = [] { (void)RequestRealtime(); };
  ENAMEL_ASSIGN_OR_RETURN(auto board, hid::HapticBoard::Open(settings));
  const hid::FeatureReport& feature = board->feature();
  std::string name = profile_name.empty() ? feature.profile : profile_name;
  ENAMEL_ASSIGN_OR_RETURN(auto profile,
                          scene::FindProfile(name.empty() ? "phantom_desktop" : name));
  MeasuredDevice out;
  out.profile = std::move(profile);
  for (size_t i = 0; i < 3; ++i) out.count_m[i] = feature.resolution_nm[i] * 1e-9;
  // The board's own peak force replaces the profile's: its motors are limited to that.
  out.profile.peak_force_mn = {
      *std::min_element(feature.peak_force_mn.begin(), feature.peak_force_mn.end()), kOfBoard};
  out.profile.axes = {feature.axes, kOfBoard};
  out.profile.board_spring.reset();
  if (feature.runs_spring()) {
    out.profile.board_spring =
        scene::BoardSpringSpec{feature.spring_rate_hz, feature.spring_delay_ticks, kOfBoard};
    out.profile.coupling_mn_per_mm = {feature.spring_kc_mn_per_mm, kOfBoard};
  }
  out.address = choice + " " + board->Name();
  out.device = std::move(board);
  out.real = true;
  return out;
}

int64_t Now_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * std::nano::den + t.tv_nsec;
}

void SleepUntil(int64_t due_ns) {
  timespec t{due_ns / std::nano::den, due_ns % std::nano::den};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

}  // namespace enamel::station
