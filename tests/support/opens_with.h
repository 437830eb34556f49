#pragma once

#include "station/devices/device_node.h"

namespace enamel::test {

// While it lives, the station opens device files with this call in place of open(2).
class OpensWith {
 public:
  explicit OpensWith(station::OpenCall call) { station::SetOpenCall(call); }
  ~OpensWith() { station::SetOpenCall(nullptr); }
  OpensWith(const OpensWith&) = delete;
  OpensWith& operator=(const OpensWith&) = delete;
};

}  // namespace enamel::test
