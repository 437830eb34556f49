#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/program/declare.h"
#include "server/app/places.h"

// Where the commands of enamel-server go. Used once, at start, by one thread.
namespace enamel::server::app {

// Of a document that somebody names on the command line: an exercise, a rubric.
inline constexpr size_t kMaxDocumentBytes = 1 << 20;

// Where commands go: the program itself, or `admin`.
struct CommandGroup {
  CLI::App& parent;
  std::function<Status()>& chosen;  // set by parsing to the command that was asked for
};

// A command of the group (declare.h). It runs after the parsing, and `run` returns a Status.
template <typename Options, typename Run>
program::DeclaredCommand<Options> Declare(CommandGroup group, const std::string& name,
                                          const std::string& help, Run run) {
  return program::Declare<Options>(
      group.parent, name, help, std::move(run),
      [&chosen = group.chosen](std::function<Status()> command) { chosen = std::move(command); });
}

// All roles, for an option's check.
std::vector<std::string> RoleNames();

// Describes an option that names a person.
inline constexpr char kLoginHelp[] = "Login of the person (list-people)";

// The id in examples: of an attempt, a reference or an assignment.
inline constexpr char kSomeId[] = "6f1c9a52-3d0e-4b7a-9c41-2f8d5e07a613";

// --data, as every command but `serve` takes it: from the command line or from ENAMEL_DATA, and
// from one of them.
CLI::Option* AddData(CLI::App* cmd, std::filesystem::path& data);

// An example of a command that takes --data, which is then the packages' folder (example.h).
void AddExample(CLI::App* cmd, const std::string& arguments);

// --identity, for TakeIdentity (data_folder.h).
void AddIdentity(CLI::App* cmd, std::filesystem::path& identity);

// --database, --schema, --s3-… and --key-…, for `init` and `move`.
void AddPlaces(CLI::App* cmd, Places& places);

}  // namespace enamel::server::app
