#include "tests/station/render/second_client.h"

#include <X11/Xlib.h>

#include "common/base/check.h"

namespace enamel::station::render {

struct SecondClient::Impl {
  Display* display = XOpenDisplay(nullptr);
  ::Window own = 0;
  int taps = 0;

  // No window manager stands between it and the display.
  ::Window Find(const std::string& title) const {
    ::Window root = 0, parent = 0, *all = nullptr;
    unsigned count = 0;
    if (XQueryTree(display, DefaultRootWindow(display), &root, &parent, &all, &count) == 0)
      return 0;
    ::Window found = 0;
    for (unsigned i = 0; i < count; ++i) {
      char* name = nullptr;
      if (XFetchName(display, all[i], &name) == 0) continue;
      if (name != nullptr && title == name) found = all[i];
      XFree(name);
    }
    XFree(all);
    return found;
  }
};

SecondClient::SecondClient() : impl_(std::make_unique<Impl>()) {
  ENAMEL_CHECK(impl_->display != nullptr);
  impl_->own = XCreateSimpleWindow(impl_->display, DefaultRootWindow(impl_->display), 0, 0, 40, 30,
                                   0, 0, 0xffffff);
  XSelectInput(impl_->display, impl_->own, StructureNotifyMask);
  XMapWindow(impl_->display, impl_->own);
  // A window that is not on the display yet cannot have the keyboard.
  XEvent event;
  do XNextEvent(impl_->display, &event);
  while (event.type != MapNotify);
}

SecondClient::~SecondClient() { XCloseDisplay(impl_->display); }

void SecondClient::TakeKeyboard() {
  XSetInputFocus(impl_->display, impl_->own, RevertToParent, CurrentTime);
  XSync(impl_->display, False);
}

bool SecondClient::GiveKeyboard(const std::string& title) {
  const ::Window window = impl_->Find(title);
  if (window == 0) return false;
  XSetInputFocus(impl_->display, window, RevertToParent, CurrentTime);
  XSync(impl_->display, False);
  return true;
}

bool SecondClient::TapKey(const std::string& title, unsigned keycode) {
  const ::Window window = impl_->Find(title);
  if (window == 0) return false;
  for (const int type : {KeyPress, KeyRelease}) {
    XEvent event{};
    event.xkey.type = type;
    event.xkey.display = impl_->display;
    event.xkey.window = window;
    event.xkey.root = DefaultRootWindow(impl_->display);
    event.xkey.same_screen = True;
    event.xkey.keycode = keycode;
    event.xkey.time = static_cast<Time>(++impl_->taps);
    XSendEvent(impl_->display, window, True, type == KeyPress ? KeyPressMask : KeyReleaseMask,
               &event);
  }
  XSync(impl_->display, False);
  return true;
}

void SecondClient::MovePointer(int dx, int dy) {
  XWarpPointer(impl_->display, None, None, 0, 0, 0, 0, dx, dy);
  XSync(impl_->display, False);
}

void SecondClient::PutPointer(int x, int y) {
  XWarpPointer(impl_->display, None, DefaultRootWindow(impl_->display), 0, 0, 0, 0, x, y);
  XSync(impl_->display, False);
}

}  // namespace enamel::station::render
