#pragma once

#include <filesystem>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"

namespace enamel::station {

struct SalvagedAttempt {
  Uuid id;
  uint32_t chunks = 0;    // saved: those from the first on without a hole
  uint32_t expected = 0;  // as the damaged spool counted them
  bool sealed = false;    // whole, with its end
  Status problem;         // what could not be saved, or ok
};
struct Salvaged {
  std::vector<SalvagedAttempt> attempts;
  size_t tickets = 0;
};

// Saves what can be read of the damaged spool in `from` into a new one in `to`, which must have
// none: row by row, by index and by position, forwards and backwards, each recording as far as its
// chain goes (trace::ChainVerifier). A file that is cut short is read as far as it goes; one whose
// first page is destroyed gets that of a new spool, as all have the same. `from` is not changed: it
// is worked on in a copy. Errors: kNotFound, kConflict when `to` has a spool, kStorage when nothing
// is saved: then none is made.
Result<Salvaged> SalvageSpool(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace enamel::station
