#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "station/session/workplace.h"

// What the subcommands of enamel-station do, apart from running an attempt (attempt.h). They print
// to standard output and return the first thing that went wrong.
namespace enamel::station {

struct EnrolOptions {
  std::filesystem::path data;
  std::string server, code;
  std::string name;    // empty: as before
  bool again = false;  // under the old id and key, at a server that was restored and forgot it
};
Status EnrolStation(const EnrolOptions& options);

// Takes a ticket now, to make the attempt later with or without the server, and prints how.
struct ReserveCommand {
  WorkplaceOptions workplace;
  std::string exercise, profile, login, password, pin;
};
Status ReserveAttempt(const ReserveCommand& options);
Status ListReserved(const std::filesystem::path& data);
// Hands one back that is not wanted any more: with its PIN, or with its person's password.
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

// The scenes and exercises the project makes itself.
void PrintScenes();
void PrintProfiles();

}  // namespace enamel::station
