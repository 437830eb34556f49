#pragma once

#include <filesystem>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"

namespace enamel::station {

struct SalvagedAttempt {
  Uuid id;
  uint32_t chunks = 0;    // saved, from the first on without a hole
  uint32_t expected = 0;  // by the damaged spool's count
  bool sealed = false;    // complete, with its end
  Status problem;         // what could not be saved, or ok
};
struct Salvaged {
  std::vector<SalvagedAttempt> attempts;
  size_t tickets = 0;
};

// Saves the readable contents of the damaged spool in `from` into a new one in `to`, which must
// have none. Reads row by row, by index and by position, forwards and backwards, and each recording
// as far as its chain goes (trace::ChainVerifier). A file that is cut short is read up to the cut.
// A destroyed first page is replaced by a new spool's, since all have the same. `from` is not
// changed: the work is done on a copy. Errors: kNotFound, kConflict when `to` has a spool, kStorage
// when nothing could be saved; then no spool is made.
Result<Salvaged> SalvageSpool(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace enamel::station
