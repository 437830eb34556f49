#include "station/app/command_line.h"

#include <cstdio>
#include <cstdlib>

#include "common/program/log.h"

namespace enamel::station {

int Finish(const Status& status) {
  if (status.ok()) return 0;
  // So that the reason follows the output when both go to one file.
  std::fflush(stdout);
  program::SayError(status.message());
  return kFailed;
}

void AddCpu(CLI::App* cmd, int& cpu) {
  cmd->add_option("--cpu", cpu, "Bind the haptic loop to this processor, 0 the first")
      ->check(CLI::Range(0, 1023));
}

std::string Environment(const char* name) {
  const char* set = std::getenv(name);
  return set == nullptr ? "" : set;
}

}  // namespace enamel::station
