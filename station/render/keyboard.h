#pragma once

#include <array>
#include <functional>

#include "station/render/input.h"

namespace enamel::station::render {

// The keyboard in front of a person. GLFW numbers keys by their place on a US keyboard: on a French
// one its M is the key of the comma, and W A S D are printed Z Q S D. A letter that the window names
// (M: mirror) is a key by what is printed on it; keys that lie well under a hand (tilt) are chosen by
// their place, and named by what is printed there. Thread safety: one thread.
class Keyboard {
 public:
  // `printed`: the text of the key at this place, in UTF-8, by the layout in use; null where it
  // writes nothing (glfwGetKeyName).
  explicit Keyboard(std::function<const char*(int place)> printed) : printed_(std::move(printed)) {}

  // The Key of this place: the capital letter or the sign printed on it. The place itself where that
  // is not one ASCII character, as for a Cyrillic letter (Russian keyboards show the Latin one, too), and
  // for digits, which a French keyboard writes with Shift.
  int At(int place) const;
  // A key's event by its place. A release is of the key that was pressed, whatever layout was chosen
  // in between.
  InputEvent Event(int place, bool pressed, int mods, bool repeat);

  static constexpr int kPlaces = 349;  // GLFW_KEY_LAST + 1; screen.cpp checks it

 private:
  std::function<const char*(int)> printed_;
  std::array<int, kPlaces> held_{};  // 0: not held
};

}  // namespace enamel::station::render
