#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/base/result.h"

// Declares a program's command: its name, its options and its function. Used once, at start, by one
// thread.
namespace enamel::program {

// A new command `cmd`; `options`, a value that its options write into and that lives as long as it,
// is what runs get.
template <typename Options>
struct DeclaredCommand {
  CLI::App* cmd;
  Options& options;
};

// When the command is the one that was asked for, `chosen` gets `run` with the options as parsed:
// to run it, or to keep it until the parsing is done. `run` takes `const Options&` and returns
// Status.
template <typename Options, typename Run, typename Chosen>
DeclaredCommand<Options> Declare(CLI::App& parent, const std::string& name, const std::string& help,
                                 Run run, Chosen chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* cmd = parent.add_subcommand(name, help);
  cmd->callback([options, run = std::move(run), chosen = std::move(chosen)] {
    chosen([options, run] { return run(*options); });
  });
  return {cmd, *options};
}

}  // namespace enamel::program
