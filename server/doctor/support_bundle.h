#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "server/app/serve.h"

namespace enamel::server::app {

struct SupportBundleCommand {
  ServeOptions serve;
  std::string settings;          // as --print-settings shows them
  std::filesystem::path target;  // a file; "-": standard output
  std::filesystem::path log;     // of the server; "-": standard input; empty: none
};

// Writes what helps somebody elsewhere to find a fault (schemas/support_bundle.md): one JSON
// document that its sender can read first. It has no secrets, no personal data and no name of the computer:
// hosts, and names that the database knows, are taken out (scrub.h), and without the database the log is left out. Errors:
// kStorage (the target cannot be written, as where the disk is full; nothing is left of it).
Status SupportBundle(const SupportBundleCommand& command);

}  // namespace enamel::server::app
