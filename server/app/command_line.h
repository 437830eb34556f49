#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/base/result.h"

// How a command of enamel-server is declared, beside what it does: its name, its options and what
// to run. Used once, at start, by one thread.
namespace enamel::server::app {

// Where commands go: the program itself, or `admin`.
struct CommandGroup {
  CLI::App& parent;
  std::function<Status()>& chosen;  // set by parsing to the command that was asked for
};

// A new command `cmd`; `options`, a value that its options write into and that lives as long as it,
// is what `run` gets.
template <typename Options>
struct DeclaredCommand {
  CLI::App* cmd;
  Options& options;
};

template <typename Options, typename Run>
DeclaredCommand<Options> Declare(CommandGroup group, const std::string& name,
                                 const std::string& help, Run run) {
  auto options = std::make_shared<Options>();
  CLI::App* cmd = group.parent.add_subcommand(name, help);
  cmd->callback([options, run = std::move(run), &chosen = group.chosen] {
    chosen = [options, run] { return run(*options); };
  });
  return {cmd, *options};
}

// --data, as every command but `serve` takes it: from the command line or from ENAMEL_DATA, and
// from one of them.
CLI::Option* AddData(CLI::App* cmd, std::filesystem::path& data);

}  // namespace enamel::server::app
