#pragma once

#include <filesystem>
#include <functional>
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
  // Asked some fifty times a second: true once the person at a device wants to finish and hand in. May
  // be empty.
  std::function<bool()> finish = {};
};

// How an attempt ended when nothing was lost.
struct AttemptResult {
  Uuid attempt;
  bool uploaded = false;  // sealed and durable on the server
  std::string not_uploaded_because;
  std::string refused;  // not empty: why the server refuses the recording
  // By a signal, or because its window was closed: all of it is stored and it has no end, so that it can
  // be resumed.
  bool left = false;
};

// Runs one attempt from sign-in to the last acknowledgement. Fetches what it needs, runs the tick
// loop, the recorder and the uplink on their own threads, shows progress, and seals. A signal
// to stop (stop_signals.h) leaves the attempt: force 0, everything stored, no seal. While the rest
// is being sent after the end, it ends the sending.
//
// Errors: anything that fails before the first tick (not enrolled, server not reachable, wrong
// password, unknown exercise, profile or operator, no display, nowhere to write the facts; the
// server then knows of no attempt), and a spool that cannot be written. After the first tick an
// unreachable server is no error: see AttemptResult.
Result<AttemptResult> RunAttempt(const RunOptions& options);

}  // namespace enamel::station
