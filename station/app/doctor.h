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

// One requirement of a station, and whether it is met here.
struct Finding {
  std::string what;  // "real-time rights"
  Verdict verdict = Verdict::kOk;
  std::string found;
  std::string advice;  // what to do; empty if all is well
};

// Checks everything an attempt needs: enrolment, server with its certificate and clock, disk,
// spool, real-time rights, timer, devices and their delay, graphics. Changes nothing, except that
// it writes a file and removes it again. Waits are bounded: for a server that does not answer, by
// ServerLink::kTimeout to connect, then kSilence.
std::vector<Finding> Examine(const DoctorCommand& options);

// Prints Examine's findings, one a line. Errors: kUnavailable if one failed (warnings are no
// error).
Status Doctor(const DoctorCommand& options);

}  // namespace enamel::station
