#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "station/spool/spool.h"

namespace enamel::station {

// VerifyRecordings' finding for one attempt.
struct SpoolVerdict {
  SpooledAttempt attempt;
  Status status;  // first error, or ok
};

// Checks for every attempt: chunks 0 to the last counted, chain, signatures (when `station_key` is
// given), seal, and the counts stored with them. `pages` receives faults of the file itself;
// without it they are an error. Changes nothing. Errors: those of Spool.
Result<std::vector<SpoolVerdict>> VerifyRecordings(
    Spool& spool, const std::optional<trace::PublicKey>& station_key, Status* pages = nullptr);

}  // namespace enamel::station
