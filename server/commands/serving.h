#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/program/log.h"
#include "server/app/serve.h"

namespace CLI {
class App;
}

// What runs until it is stopped (`serve`, `work`), and what is there to try it with (`seed-demo`), on the command
// line (command_line.h).
namespace enamel::server::app {

struct CommandGroup;
void DeclareServe(CommandGroup root);
void DeclareWork(CommandGroup root);
void DeclareDoctor(CommandGroup root);
void DeclareSupportBundle(CommandGroup root);
void DeclareSeed(CommandGroup root);

// The settings of `serve`, from the command line, the environment and the file, for commands that
// look at the same server.
struct ServeSettings {
  ServeOptions serve;
  std::filesystem::path config;
  program::LogOptions log;
};
// `settings` outlives the parsing.
void AddServeSettings(CLI::App* cmd, ServeSettings& settings);
// After the parsing.
Status FinishServeSettings(CLI::App& cmd, ServeSettings& settings);

}  // namespace enamel::server::app
