#pragma once

#include <string>

#include "server/training/types.h"

namespace enamel::server {

// The author of an action, for the audit trail. Zero id: the system or the command line.
struct Actor {
  Uuid person;
  std::string via;  // "page", "station <name>", "command line", "job"
};

}  // namespace enamel::server
