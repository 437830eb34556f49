#include "station/render/display_watch.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "common/base/check.h"

namespace enamel::station::render {
namespace {

std::function<void()> leave_then;

// Xlib's XIOErrorHandler. It must not return, or Xlib calls exit(), whose handlers would draw.
int OnDisplayLost(void*) {
  if (auto leave = std::exchange(leave_then, {})) leave();
  ::_exit(EXIT_FAILURE);
}

using Handler = int (*)(void*);
// XSetIOErrorHandler of the Xlib that GLFW has loaded; null: there is none.
Handler (*SetHandler())(Handler) {
  void* xlib = ::dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  if (xlib == nullptr) return nullptr;
  return reinterpret_cast<Handler (*)(Handler)>(::dlsym(xlib, "XSetIOErrorHandler"));
}

}  // namespace

DisplayWatch::DisplayWatch(std::function<void()> leave) {
  ENAMEL_CHECK(!leave_then);
  leave_then = std::move(leave);
  if (auto set = SetHandler()) set(&OnDisplayLost);
}

DisplayWatch::~DisplayWatch() {
  leave_then = {};
  if (auto set = SetHandler()) set(nullptr);
}

}  // namespace enamel::station::render
