#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/base/result.h"
#include "common/program/command_settings.h"
#include "station/app/workplace_settings.h"

// How a command of enamel-station is declared, beside what it does: its name, its options and what
// to run. Used once, at start, by one thread.
namespace enamel::station {

// Exit codes; 2 is for a command line that cannot be understood.
inline constexpr int kFailed = 1, kUsage = 2, kNotUploaded = 3;

// Says what went wrong on standard error; the exit code.
int Finish(const Status& status);

// Where commands go, and what they have in common. All of it outlives the parsing.
struct CommandGroup {
  CLI::App& app;
  WorkplaceSettings& place;
  const program::CommandSettings& settings;
  int& exit_code;  // of the command that was asked for
};

// A new command `cmd`; `options`, a value that its options write into and that lives as long as it,
// is what `run` gets. `run` returns a Status.
template <typename Options>
struct DeclaredCommand {
  CLI::App* cmd;
  Options& options;
};

template <typename Options, typename Run>
DeclaredCommand<Options> Declare(CommandGroup group, const std::string& name,
                                 const std::string& help, Run run) {
  auto options = std::make_shared<Options>();
  CLI::App* cmd = group.app.add_subcommand(name, help);
  cmd->callback([options, run = std::move(run), &exit_code = group.exit_code] {
    exit_code = Finish(run(*options));
  });
  return {cmd, *options};
}

// --cpu, of commands with a haptic loop.
void AddCpu(CLI::App* cmd, int& cpu);

// Of an environment variable; empty where it is not set.
std::string Environment(const char* name);

// The window; what it runs is also what the program does without any command.
struct OpenCommand {
  CLI::App* cmd;
  std::function<Status()> run;
};
OpenCommand DeclareOpen(CommandGroup group);
void DeclareRun(CommandGroup group);
void DeclareEnrol(CommandGroup group);
void DeclareReserve(CommandGroup group);
void DeclareReplay(CommandGroup group);
void DeclareVerify(CommandGroup group);
void DeclareImport(CommandGroup group);
void DeclareSimulate(CommandGroup group);
// 'scenes' and 'profiles': what is built in.
void DeclareLists(CommandGroup group);

}  // namespace enamel::station
