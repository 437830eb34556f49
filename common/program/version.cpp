#include "common/program/version.h"

#include "common/program/commit.h"

namespace enamel::program {

std::string VersionText(const std::string& program) {
  const std::string commit = kCommit;
  return program + " " + kVersion + (commit.empty() ? "" : " (" + commit + ")");
}

}  // namespace enamel::program
