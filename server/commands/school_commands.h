#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"

// The commands with which whoever runs an installation looks after its other schools
// (school_folder.h). Each takes the installation's data folder, prints its outcome to standard
// output, and leaves a row in the installation's audit trail; servers that run follow within
// seconds.
namespace enamel::server::app {

struct SchoolCommand {
  std::filesystem::path data;  // of the installation
  std::string name;
  std::vector<std::string> hosts;
  std::string admin;  // add: login of its first admin, whose password is printed; empty: none
  std::filesystem::path target, json;  // export
  std::string confirm;                 // delete: the name once more
};
Status AddSchool(const SchoolCommand& command);
Status ListSchools(const SchoolCommand& command);
// Gives it these host names instead of those that it has.
Status SetSchoolHosts(const SchoolCommand& command);
Status SuspendSchool(const SchoolCommand& command);
Status ResumeSchool(const SchoolCommand& command);
// A backup, which `restore` makes an installation of its own of.
Status ExportSchool(const SchoolCommand& command);
// Errors: kConflict (it is not suspended, or `confirm` is not its name), kUnavailable (a server has
// not let go of it).
Status RemoveSchool(const SchoolCommand& command);

struct CommandGroup;
// On the command line (command_line.h).
void DeclareSchools(CommandGroup root);

}  // namespace enamel::server::app
