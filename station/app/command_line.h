#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/units.h"
#include "common/program/command_settings.h"
#include "common/program/declare.h"
#include "station/app/workplace_settings.h"

// How subcommands of enamel-station are registered. Used once, at start, by one thread.
namespace enamel::station {

// Exit codes; 2 is for a command line that cannot be parsed.
inline constexpr int kFailed = 1, kUsage = 2, kNotUploaded = 3;

// Prints the error to standard error; returns the exit code.
int Finish(const Status& status);

// Where commands are registered, and what they share. All of it outlives the parsing.
struct CommandGroup {
  CLI::App& app;
  WorkplaceSettings& place;
  const program::CommandSettings& settings;
  int& exit_code;  // of the command that ran
};

// A command of the program (declare.h). It runs while it is parsed, and `run` returns a Status.
template <typename Options, typename Run>
program::DeclaredCommand<Options> Declare(CommandGroup group, const std::string& name,
                                          const std::string& help, Run run) {
  return program::Declare<Options>(
      group.app, name, help, std::move(run),
      [&exit_code = group.exit_code](const auto& command) { exit_code = Finish(command()); });
}

// The arguments of a command line, `open` added where an option of it comes before any command: as
// 'enamel-station --data FOLDER'. Options of the program itself may come before that.
std::vector<const char*> WithOpen(int argc, const char* const* argv, const CLI::App& app);

// Adds --cpu, for commands with a haptic loop.
void AddCpu(CLI::App* cmd, int& cpu);

// Adds --unit and --scale: the size of the coordinates in a mesh file.
void AddScale(CLI::App* cmd, mesh::FileScale& scale);

// Adds --operator: the simulated person who holds the device.
void AddOperator(CLI::App* cmd, std::string& name);

// Value of an environment variable; empty if unset.
std::string Environment(const char* name);

// The window, which also opens when the program is started without a command.
struct OpenCommand {
  CLI::App* cmd;
  std::function<Status()> run;
};
OpenCommand DeclareOpen(CommandGroup group);
// All commands, in the order of the help, and the program's own help.
OpenCommand DeclareCommands(CommandGroup group);
void DeclareRun(CommandGroup group);
void DeclareEnrol(CommandGroup group);
void DeclareReserve(CommandGroup group);
void DeclareReplay(CommandGroup group);
void DeclareVerify(CommandGroup group);
void DeclareImport(CommandGroup group);
void DeclareTarget(CommandGroup group);
void DeclareSimulate(CommandGroup group);
// 'devices', 'calibrate', 'first-hour', 'doctor' and 'loop-test'.
void DeclareDeviceCommands(CommandGroup group);
// 'upload', and 'spool' with its commands.
void DeclareSpool(CommandGroup group);
// 'scenes' and 'profiles': list what is built in.
void DeclareLists(CommandGroup group);

}  // namespace enamel::station
