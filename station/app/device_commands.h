#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>

#include "common/base/result.h"

namespace CLI {
class App;
}

namespace enamel::station {

// Adds 'devices', 'calibrate', 'first-hour', 'doctor' and 'loop-test'. `finish` turns an outcome into the exit
// code, which is written to `exit_code`; `default_data` is the folder used without --data; `own_settings`
// are CommandSettings::own. All must
// outlive the parsing.
void RegisterDeviceCommands(CLI::App& app, const std::string& default_data,
                            std::function<int(const Status&)> finish, int* exit_code,
                            const std::set<std::string>& own_settings);

}  // namespace enamel::station
