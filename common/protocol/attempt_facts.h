#pragma once

#include <cstdint>

#include "common/protocol/station.pb.h"

namespace enamel::protocol {

// What a station says of an attempt beside its recording: not signed, not an input of the core, and
// true whether the server believes it or not. It is kept in the spool with the attempt, told with
// OpenAttempt, each time anew, and never changed by the server. CONTRIBUTING.md, "Where a fact of
// an attempt belongs", says what is to stand here, and what every new one touches.
struct AttemptFacts {
  uint32_t resumed = 0;  // how often it was taken up again after the station had crashed

  bool operator==(const AttemptFacts&) const = default;
};

// A fact that the other side does not know reads as its default here, and is ignored there.
void SetFacts(const AttemptFacts& facts, wire::OpenAttempt& message);
AttemptFacts FactsOf(const wire::OpenAttempt& message);

}  // namespace enamel::protocol
