#pragma once

#include <string>

#include "common/protocol/refusals.h"
#include "server/training/types.h"

namespace enamel::server::app {

// An attempt's state, for people. The database calls an attempt failed that cannot be scored yet:
// once the exercise has a reference, it is scored by itself.
inline std::string StateText(const AttemptRow& row) {
  const bool waits =
      row.state == AttemptState::kFailed && row.problem_field == protocol::kNoReference;
  return waits ? "waits for a reference" : AttemptStateName(row.state);
}

}  // namespace enamel::server::app
