#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "station/spool/spool.h"

namespace enamel::station {

// What VerifyRecordings found in one attempt.
struct SpoolVerdict {
  SpooledAttempt attempt;
  Status status;  // first thing that is wrong, or ok
};

// Chunks 0 to the last counted, chain, signatures (when `station_key` is given), seal, and what is
// counted beside them, of every attempt. `pages` gets what is wrong with the file as such; without
// it that is an error. Changes nothing. Errors: those of Spool.
Result<std::vector<SpoolVerdict>> VerifyRecordings(
    Spool& spool, const std::optional<trace::PublicKey>& station_key, Status* pages = nullptr);

}  // namespace enamel::station
