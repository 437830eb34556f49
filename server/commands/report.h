#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

namespace enamel::server::app {

struct ReportOptions {
  std::filesystem::path data;
  std::string attempt;         // UUID text
  int wait_s = 0;              // for a running server to score it
  std::string page_url;        // printed as it is
  std::filesystem::path json;  // the same facts as JSON; empty: none
};

// Prints a short table about a scored attempt: score and reasons, volumes, forces, trace, lost
// points. Errors: kNotFound; kUnavailable (not scored in time); kConflict (failed or quarantined,
// with the reason).
Status Report(const ReportOptions& options);

struct CommandGroup;
// On the command line (command_line.h).
void DeclareReport(CommandGroup root);

}  // namespace enamel::server::app
