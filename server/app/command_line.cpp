#include "server/app/command_line.h"

#include <cstdlib>

namespace enamel::server::app {

// The environment is read here and not by the parser, which would let it overrule another command's
// option that has the same place.
CLI::Option* AddData(CLI::App* cmd, std::filesystem::path& data) {
  auto* option = cmd->add_option("--data", data, "Data folder of the server (or ENAMEL_DATA)");
  const char* given = std::getenv("ENAMEL_DATA");
  if (given != nullptr) data = given;
  return option->required(given == nullptr);
}

void AddIdentity(CLI::App* cmd, std::filesystem::path& identity) {
  cmd->add_option("--identity", identity,
                  "Folder with station.crt, station.key and ticket.key of another server of the "
                  "school: taken over where there are none, and refused where there are others");
}

}  // namespace enamel::server::app
