#include "station/uplink/backoff.h"

#include <algorithm>

namespace enamel::station {

Backoff::Duration Backoff::Next() {
  Duration full = next_;
  next_ = std::min(longest_, full * 2);
  return full - Duration(random_() % static_cast<unsigned>(full.count() / 2 + 1));
}

}  // namespace enamel::station
