#pragma once

#include "common/base/result.h"

// What measures laws, cutting and machines is a program of its own, enamel-lab (station/lab). Its
// older names here start it.
namespace enamel::station {

// Whether a command line names one of them: qualify, fit-damping, explain or frame-bench.
bool IsLabCommand(int argc, const char* const* argv);

// Replaces this program by enamel-lab with the same command line. Returns only where that failed.
// Errors: kNotFound with what to do.
Status RunLabCommand(int argc, const char* const* argv);

}  // namespace enamel::station
