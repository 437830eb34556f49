#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "server/app/places.h"

namespace enamel::server::app {

struct MoveCommand {
  std::filesystem::path data;  // a school's data folder; no server runs
  std::filesystem::path to;    // absent or empty, or an earlier try's
  Places places;               // of its rows, blobs and keys; empty: in the new folder
  bool accept_damage = false;
  std::filesystem::path json;  // empty: none
};

// Moves a school to another place (storage/move/move.h) and prints the contents of the new place.
Status Move(const MoveCommand& command);
struct CommandGroup;
// On the command line (command_line.h).
void DeclareMove(CommandGroup root);

}  // namespace enamel::server::app
