#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/program/log.h"
#include "common/program/settings.h"

namespace CLI {
class App;
}

namespace enamel::program {

// Adds --log-format and --log-level, which `log` has the defaults of.
void AddLogOptions(CLI::App& app, LogOptions& log);

// Settings and log of a program with commands. Before a command runs, what its command line did not
// say is taken from the environment, then from a settings file and a policy (settings.h); then the log is
// set up. A policy's setting that no command has, or that cannot be taken, is ignored with a warning. Another
// that cannot be taken ends the parsing as a wrong command line does (CLI::ValidationError). Main
// thread only.
class CommandSettings {
 public:
  struct Where {
    std::string program;                // its name in the log
    std::string prefix;                 // of its environment variables
    std::filesystem::path system_file;  // read where no other is named and it is there
    // The file is another program's too: keys that no command here has are ignored.
    bool shared = false;
    // The policy that is kept in this data folder; none: the program has none.
    std::function<std::vector<PolicySetting>(const std::filesystem::path& data)> policy = {};
  };
  // `app` outlives this, and this the parsing.
  CommandSettings(CLI::App& app, Where where);

  // Adds --config, --log-format and --log-level. When every command is there.
  void Add();
  // Does for a program without commands what Add does for each command. Errors: kInvalidInput.
  Status Apply(CLI::App& command);

  const LogOptions& log() const { return log_; }
  // Settings that environment or file gave, whatever command has them.
  const std::set<std::string>& own() const { return own_; }

 private:
  std::vector<std::string> TakePolicy(CLI::App& command, const std::set<std::string>& nearer,
                                      const std::set<std::string>& known);

  CLI::App& app_;
  const Where where_;
  LogOptions log_;
  std::string config_;
  std::set<std::string> own_;
};

}  // namespace enamel::program
