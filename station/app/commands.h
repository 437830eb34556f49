#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// What the subcommands of enamel-station do, apart from running an attempt (attempt.h). They print
// to standard output and return the first thing that went wrong.
namespace enamel::station {

struct EnrolOptions {
  std::filesystem::path data;
  std::string server, code, name;
};
Status EnrolStation(const EnrolOptions& options);

// Sends what is in the spool and not yet on the server. Errors: kUnavailable when it is not
// reachable; the worst refusal when the server will not have some of it.
// `server`: HOST:PORT when it has moved since enrolment; else empty.
Status UploadSpool(const std::filesystem::path& data, const std::string& server);

Status ListSpool(const std::filesystem::path& data);
Status VerifySpool(const std::filesystem::path& data);
Status ExportFromSpool(const std::filesystem::path& data, const std::string& attempt,
                       const std::filesystem::path& out);

struct SimulateCommand {
  std::string scene = "builtin:molar";  // or a folder written by import
  std::string profile = "phantom_desktop";
  std::string operator_name = "dentist";
  int voxel_um = 50;
  uint64_t seed = 0;
  std::filesystem::path json;
};
Status SimulateAttempt(const SimulateCommand& options);

void PrintDevices();
void PrintProfiles();

}  // namespace enamel::station
