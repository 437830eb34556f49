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
  bool all = false;            // every figure, not the score and its dearest mistakes alone
  std::filesystem::path json;  // the same facts as JSON; empty: none
};

// Prints a scored attempt: its points, the three mistakes that cost most and what to do about the
// dearest. Errors: kNotFound; kUnavailable (not scored in time); kConflict (failed or quarantined,
// with the reason).
Status Report(const ReportOptions& options);

struct CommandGroup;
// On the command line (command_line.h).
void DeclareReport(CommandGroup root);

}  // namespace enamel::server::app
