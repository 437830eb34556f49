#pragma once

#include <string>

#include "common/base/result.h"

// A program's messages while it runs, on standard error.
namespace enamel::program {

struct LogOptions {
  std::string format =
      "text";  // or "json": one object a line, {"time", "level", "message", "request", "attempt"}
  std::string level = "info";          // trace, debug, info, warning, error
  std::string name = "enamel-server";  // of the program
};

// Sets spdlog's default logger; at start, before other threads. JSON lines are for collectors
// (systemd's journal, a log shipper): time is UTC with milliseconds (RFC 3339), the message is
// escaped, so that nothing a client sends can begin a line of its own, and what is not UTF-8 in it
// is replaced (AsUtf8). A line that was logged while a LogRequest or LogAttempt named a request or an
// attempt has its id, in text as "[request ID] [attempt ID]" before the message. Errors:
// kInvalidInput.
Status SetUpLog(const LogOptions& options);

// As set up: standard error is for lines of JSON, and progress and advice are left out.
bool LogIsJson();

// Whether a command line, or where it says nothing the environment (`prefix` and LOG_FORMAT), asks
// for JSON: asked before it is parsed, so that what is wrong with it is said in JSON too.
bool AsksForJson(int argc, const char* const* argv, const std::string& prefix);

// Reports to the person who runs the program, on standard error: "NAME: message". Where the log is
// JSON, a line of it, at level "error" or "warning", whatever the log level.
void SayError(const std::string& message);
void SayWarning(const std::string& message);

}  // namespace enamel::program
