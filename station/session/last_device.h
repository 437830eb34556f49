#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"

// The device with motors that was last cut with at this station: DATA/last_device.json
// (schemas/station_settings.md, "The device that was last cut with"). It has nothing of any person.
// Thread safety: functions, any thread; read and write files. Real-time: never.
namespace enamel::station {

struct LastDevice {
  std::string title;    // as the window calls it
  std::string profile;  // of the catalogue

  bool operator==(const LastDevice&) const = default;
};

// A file that cannot be read counts as none, and is logged as a warning.
std::optional<LastDevice> LastDeviceOf(const std::filesystem::path& data);

// Replaces it. Errors: those of WriteFileDurably.
Status KeepLastDevice(const std::filesystem::path& data, const LastDevice& device);

}  // namespace enamel::station
