#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "station/hid/open_device.h"
#include "station/session/workplace.h"

namespace enamel::station {

struct RunOptions {
  WorkplaceOptions workplace;
  std::string exercise, profile, login, password;
  std::string assignment;    // its id; empty: whichever of the exercise can be begun
  hid::DeviceChoice device;  // empty: a simulated one, held by the operator
  std::string operator_name = "student";
  uint64_t seed = 0;  // of the operator's tremor; 0: the operator's own
  bool lockstep = false;
  int cpu = -1;  // bind the loop to this processor; -1: to none
  bool window = false;
  std::filesystem::path screenshot;
  std::filesystem::path json;
  bool as_reference = false;
  protocol::AttemptFacts facts;  // as chosen; one that is resumed has its own
  std::string resume;            // an attempt that was cut off, or "last"; else empty
  std::string reserved;          // an attempt whose ticket was taken before; else empty
  std::string pin;               // of the reserved ticket
  bool quiet = false;            // no progress line
  // Nothing on standard error but the log, which is for machines: neither progress nor advice.
  bool log_only = false;
};

// How an attempt ended when nothing was lost.
struct AttemptResult {
  Uuid attempt;
  bool uploaded = false;  // sealed and durable on the server
  std::string not_uploaded_because;
  std::string refused;  // not empty: the server will not have it, for this reason
  // Interrupted, or its window was closed: the recording is sealed and scored as far as it goes.
  bool ended_early = false;
  double done_ratio = 0;  // of what the operator meant to do
};

// One attempt from sign-in to the last acknowledgement: fetches what it needs, runs the tick loop,
// the recorder and the uplink on threads of their own, shows progress, ends with the seal. An
// interrupt (SIGINT, SIGTERM) ends the attempt properly: what was done is sealed and sent; another
// one, two seconds later or more, ends the sending.
//
// Errors: everything before the first tick (not enrolled, server not reachable, wrong password,
// unknown exercise, profile or operator, no display, nowhere to write the facts: the server then
// does not know of an attempt), and a spool that cannot be written. After the
// first tick an unreachable server is no error: see AttemptResult.
Result<AttemptResult> RunAttempt(const RunOptions& options);

}  // namespace enamel::station
