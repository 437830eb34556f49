#include <sodium.h>

#include <CLI/CLI.hpp>
#include <functional>

#include "common/base/utf8.h"
#include "common/program/log.h"
#include "common/program/private_memory.h"
#include "common/program/suggestion.h"
#include "common/program/version.h"
#include "server/commands/command_line.h"
#include "server/commands/commands.h"

// enamel-server. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
using namespace enamel;
using namespace enamel::server;

constexpr char kName[] = "enamel-server";

int main(int argc, char** argv) {
  program::KeepMemoryPrivate();
  // Found out before the command line is parsed, so that a refusal of the command line itself is
  // already said in the format that the log's reader expects.
  const bool json = program::AsksForJson(argc, argv, "ENAMEL_");
  (void)program::SetUpLog({.format = json ? "json" : "text"});
  if (sodium_init() < 0) {
    program::SayError("libsodium cannot be initialised on this machine");
    return 1;
  }
  CLI::App root("Enamel server: station link, storage, scoring, API and page", kName);
  root.require_subcommand(1);
  root.set_version_flag("--version", program::VersionText(kName));
  std::function<Status()> command;
  app::DeclareCommands({root, command});
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program::EndOfParse(root, error, json);
  }
  Status status = command();
  if (status.ok()) return 0;
  program::SayError(std::string(Printable(status.message())));
  return 1;
}
