#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"

namespace enamel::station {

class SpoolFile;

// How the loop went that recorded an attempt, for each time it was run to its end.
struct KeptLoopFacts {
  uint32_t run = 0;  // 0: as it was begun; n: after it was resumed n times
  int64_t ended_unix_ms = 0;
  std::string json;  // schemas/loop_facts.md
};

// Those of the attempts in a spool: they go when their attempt goes. Thread safety and errors:
// those of Spool.
class SpooledLoopFacts {
 public:
  explicit SpooledLoopFacts(SpoolFile& file) : file_(file) {}

  // Those of the same run before are replaced. Errors also: kNotFound.
  Status Put(const Uuid& attempt, const KeptLoopFacts& facts);
  // In the order of the runs.
  Result<std::vector<KeptLoopFacts>> Of(const Uuid& attempt);

 private:
  SpoolFile& file_;
};

}  // namespace enamel::station
