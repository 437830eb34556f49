#pragma once

#include <cstddef>
#include <optional>

#include "server/storage/upkeep/store_health.h"

namespace enamel::server {

// What the other servers of the school measure while this one has trouble: how many were asked, have
// answered, and have each trouble too.
struct PeersView {
  size_t asked = 0, answered = 0;
  size_t database = 0, blobs = 0, keys = 0;
};

// Whether a load balancer is to send to this server.
enum class Readiness {
  kReady,
  // With a trouble that every server has, or that is too new to have asked them, or that stops no
  // recording: were all servers taken out, nobody would be left to say what is wrong.
  kDegraded,
  kClockOff,      // not: this machine's clock is
  kNoRecordings,  // not: others can do what this one cannot, or there are no others
};
// `peers`: none: they have not been asked yet.
Readiness ReadinessOf(const StoreHealth& health, const std::optional<PeersView>& peers);

}  // namespace enamel::server
