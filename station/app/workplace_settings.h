#pragma once

#include <filesystem>
#include <string>

#include "station/session/workplace.h"

namespace CLI {
class App;
}

namespace enamel::station {

// Settings of the workplace, from the command line or a settings file
// (schemas/station_settings.md). One group for every command that opens a workplace or its spool,
// so that all get all settings.
struct WorkplaceSettings {
  std::filesystem::path data;  // the default
  std::string server;
  int64_t uplink_kbit = 0;
  int keep_days = 7;
  int64_t keep_mib = static_cast<int64_t>(Retention{}.bytes >> 20);

  WorkplaceOptions Options() const;
};

// Adds --data alone, for commands that neither send nor prune.
void AddDataOption(CLI::App& command, WorkplaceSettings& settings);
// Adds all settings. `settings` outlives the parser.
void AddWorkplaceSettings(CLI::App& command, WorkplaceSettings& settings);

}  // namespace enamel::station
