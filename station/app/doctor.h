#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace enamel::station {

struct DoctorCommand {
  std::filesystem::path data;
  std::string server;  // HOST:PORT when it has moved since enrolment
  bool graphics = true;
  std::filesystem::path json;
};

enum class Verdict : uint8_t { kOk, kWarn, kFail };

// One thing a station needs, and how it is here.
struct Finding {
  std::string what;  // "real-time rights"
  Verdict verdict = Verdict::kOk;
  std::string found;
  std::string advice;  // what to do; empty where all is well
};

// Looks at all an attempt needs: enrolment, server with its certificate and clock, disk, spool,
// real-time rights, timer, devices and their delay, graphics. Changes nothing but a file it writes
// and removes again. Slow things are bounded: a server that does not answer, by
// ServerLink::kTimeout.
std::vector<Finding> Examine(const DoctorCommand& options);

// Examine, one line each. Errors: kUnavailable when something failed (warnings are no error).
Status Doctor(const DoctorCommand& options);

}  // namespace enamel::station
