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
  std::string assignment;    // id; empty: any of the exercise that can be begun
  hid::DeviceChoice device;  // empty: a simulated one, held by the operator
  std::string operator_name = "student";
  uint64_t seed = 0;  // of the operator's tremor; 0: the operator's own
  bool lockstep = false;
  int cpu = -1;  // bind the loop to this processor; -1: to none
  bool window = false;
  std::filesystem::path screenshot;
  std::filesystem::path json;
  bool as_reference = false;
  protocol::AttemptFacts facts;    // as chosen; a resumed attempt keeps its own
  std::string resume;              // an attempt that was cut off, or "last"; else empty
  std::string reserved;            // an attempt whose ticket was taken before; else empty
  std::string pin;                 // of the reserved ticket
  std::string signer, signer_pin;  // of whoever signs an exam at the chair; empty: nobody
  bool quiet = false;              // no progress line
  // Standard error carries only the log, for machines: no progress and no advice.
  bool log_only = false;
};

// How an attempt ended when nothing was lost.
struct AttemptResult {
  Uuid attempt;
  bool uploaded = false;  // sealed and durable on the server
  std::string not_uploaded_because;
  std::string refused;  // not empty: why the server refuses the recording
  // Interrupted, or its window was closed: sealed, and scored as far as it was recorded.
  bool ended_early = false;
  double done_ratio = 0;  // of what the operator meant to do
};

// Runs one attempt from sign-in to the last acknowledgement. Fetches what it needs, runs the tick
// loop, the recorder and the uplink on their own threads, shows progress, and seals. An interrupt
// (SIGINT, SIGTERM) ends the attempt properly: the recording is sealed and sent. A second
// interrupt, at least two seconds later, ends the sending.
//
// Errors: anything that fails before the first tick (not enrolled, server not reachable, wrong
// password, unknown exercise, profile or operator, no display, nowhere to write the facts; the
// server then knows of no attempt), and a spool that cannot be written. After the first tick an
// unreachable server is no error: see AttemptResult.
Result<AttemptResult> RunAttempt(const RunOptions& options);

}  // namespace enamel::station
