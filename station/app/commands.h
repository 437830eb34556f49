#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "station/session/workplace.h"

// The subcommands of enamel-station, except running an attempt (attempt.h). They print to standard
// output and return the first error.
namespace enamel::station {

struct EnrolOptions {
  std::filesystem::path data;
  std::string server;
  std::string code;             // empty: that of `name` in `codes`
  std::filesystem::path codes;  // a table of names and codes; "-": standard input
  std::string name;             // empty: unchanged
  bool again = false;           // with the old id and key, at a server restored without them
};
Status EnrolStation(const EnrolOptions& options);

// Takes a ticket now for an attempt later, with or without the server. Prints how to use it.
struct ReserveCommand {
  WorkplaceOptions workplace;
  std::string exercise, profile, login, password, pin;
};
Status ReserveAttempt(const ReserveCommand& options);
Status ListReserved(const std::filesystem::path& data);
// Hands back an unused ticket, with its PIN or its person's password.
struct GiveBackCommand {
  WorkplaceOptions workplace;
  std::string attempt, login, password, pin;
};
Status GiveBackReserved(const GiveBackCommand& options);

struct SimulateCommand {
  std::string scene = "builtin:molar";  // or a folder written by import
  std::string profile = "phantom_desktop";
  std::string operator_name = "dentist";
  int voxel_um = 50;
  uint64_t seed = 0;
  std::filesystem::path json;
};
Status SimulateAttempt(const SimulateCommand& options);

// Lists the built-in scenes and exercises.
void PrintScenes();
void PrintProfiles();

}  // namespace enamel::station
