#pragma once

#include <functional>

namespace enamel::station::render {

// Calls `leave` when the display ends: the X server stopped, crashed, or closed the connection, as at a
// logout. Without this, Xlib ends the program at once, and a device keeps its last force. After `leave`
// the process ends with status 1, since nothing can be drawn any more. Does nothing where the window is
// not an X window.
//
// One at a time, while a Screen is open, on its thread. `leave` runs within a call of the Screen and must
// not draw.
class DisplayWatch {
 public:
  explicit DisplayWatch(std::function<void()> leave);
  ~DisplayWatch();
  DisplayWatch(const DisplayWatch&) = delete;
  DisplayWatch& operator=(const DisplayWatch&) = delete;
};

}  // namespace enamel::station::render
