#pragma once

#include "common/base/result.h"

// Measurements of laws, cutting and machines are a separate program, enamel-lab (station/lab). Its
// older names here start it.
namespace enamel::station {

// Whether a command line names the lab: qualify, fit-damping, explain or frame-bench.
bool IsLabCommand(int argc, const char* const* argv);

// Replaces this program by enamel-lab with the same command line. Returns only on failure. Errors:
// kNotFound, with what to do.
Status RunLabCommand(int argc, const char* const* argv);

}  // namespace enamel::station
