#pragma once

#include <filesystem>
#include <string>

#include "station/session/workplace.h"

namespace CLI {
class App;
}

namespace enamel::station {

// What a command line or a settings file (schemas/station_settings.md) says of the place a command
// works at. One group for every command that opens a workplace or its spool, so that no setting
// reaches one and not another.
struct WorkplaceSettings {
  std::filesystem::path data;  // the default
  std::string server;
  int64_t uplink_kbit = 0;
  int keep_days = 7;
  int64_t keep_mib = static_cast<int64_t>(Retention{}.bytes >> 20);

  WorkplaceOptions Options() const;
};

// --data alone, for commands that neither send nor prune.
void AddDataOption(CLI::App& command, WorkplaceSettings& settings);
// All of them. `settings` outlives the parser.
void AddWorkplaceSettings(CLI::App& command, WorkplaceSettings& settings);

}  // namespace enamel::station
