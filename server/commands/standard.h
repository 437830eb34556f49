#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"

// The command `standard`: a pass mark from examiners' marks and ratings (schemas/marks.md). As those
// of admin.h.
namespace enamel::server::app {

struct StandardOptions {
  std::vector<std::filesystem::path> marks;  // files that were filled in
  std::filesystem::path data;
  std::string assignment;       // its computed scores are the points that are regressed
  std::optional<double> cut;    // of the decisions whose dependability is asked for
  std::filesystem::path blank;  // write a file for Angoff's method, and compute nothing
  std::filesystem::path json;
};
Status FindStandard(const StandardOptions& options);

struct CommandGroup;
void DeclareStandard(CommandGroup program);

}  // namespace enamel::server::app
