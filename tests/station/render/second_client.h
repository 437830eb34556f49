#pragma once

#include <memory>
#include <string>

namespace enamel::station::render {

// Another program on the display that DISPLAY names, with a small window of its own: it takes the
// keyboard from the window under test, gives it back and moves the pointer, by Xlib and not by ours.
// Thread safety: one thread at a time.
class SecondClient {
 public:
  SecondClient();
  ~SecondClient();
  SecondClient(const SecondClient&) = delete;
  SecondClient& operator=(const SecondClient&) = delete;

  void TakeKeyboard();
  // To the window with this title. False: there is none.
  bool GiveKeyboard(const std::string& title);
  // Presses and lets go a key of the window with this title, by its X keycode. False: there is none.
  bool TapKey(const std::string& title, unsigned keycode);
  // From where it is, in pixels.
  void MovePointer(int dx, int dy);
  // To this place of the display.
  void PutPointer(int x, int y);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::render
