#pragma once

#include <sys/types.h>

namespace enamel::station::render {

// An X server without a screen, for this object's lifetime: Xvfb on a display number of its choice,
// reported through a pipe, so that tests may run in parallel. Sets DISPLAY.
class VirtualDisplay {
 public:
  VirtualDisplay();
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;
  // False when Xvfb is not installed or did not start.
  bool ok() const { return ok_; }

 private:
  pid_t server_ = -1;
  bool ok_ = false;
};

}  // namespace enamel::station::render
