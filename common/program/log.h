#pragma once

#include <string>

#include "common/base/result.h"

// What a program says while it runs, on standard error.
namespace enamel::program {

struct LogOptions {
  std::string format = "text";         // or "json": one object a line, {"time", "level", "message"}
  std::string level = "info";          // trace, debug, info, warning, error
  std::string name = "enamel-server";  // of the program
};

// Sets spdlog's default logger; at start, before other threads. JSON lines are for collectors
// (systemd's journal, a log shipper): time is UTC with milliseconds (RFC 3339), the message is
// escaped, so that nothing a client sends can begin a line of its own. Errors: kInvalidInput.
Status SetUpLog(const LogOptions& options);

}  // namespace enamel::program
