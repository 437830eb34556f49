#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"

namespace enamel::station {

class SpoolFile;

// Facts of the loop that recorded an attempt, for each run that ended properly.
struct KeptLoopFacts {
  uint32_t run = 0;  // 0: the first run; n: after n resumptions
  int64_t ended_unix_ms = 0;
  std::string json;  // schemas/loop_facts.md
};

// Loop facts of a spool's attempts; deleted with their attempt. Thread safety and errors: those of
// Spool.
class SpooledLoopFacts {
 public:
  explicit SpooledLoopFacts(SpoolFile& file) : file_(file) {}

  // Replaces earlier facts of the same run. Errors also: kNotFound.
  Status Put(const Uuid& attempt, const KeptLoopFacts& facts);
  // In the order of the runs.
  Result<std::vector<KeptLoopFacts>> Of(const Uuid& attempt);

 private:
  SpoolFile& file_;
};

}  // namespace enamel::station
