#pragma once

#include <cstdint>

namespace enamel::station::render {

// One thing a person did at the window. The only way in: from GLFW, or from a script that stands
// for a person (Screen::Inject), so that both take the same way from here on.
struct InputEvent {
  enum class Kind : uint8_t { kKey, kCharacter, kCursor, kButton, kWheel };
  Kind kind = Kind::kKey;
  int code = 0;          // key (GLFW_KEY_*) or mouse button; character: Unicode
  bool pressed = false;  // key, button
  int mods = 0;          // GLFW_MOD_*
  double x = 0, y = 0;   // cursor: window pixels from the upper left; wheel: notches

  static InputEvent Key(int key, bool pressed, int mods = 0) {
    return {Kind::kKey, key, pressed, mods, 0, 0};
  }
  static InputEvent Character(int unicode) { return {Kind::kCharacter, unicode, true, 0, 0, 0}; }
  static InputEvent Cursor(double x, double y) { return {Kind::kCursor, 0, false, 0, x, y}; }
  static InputEvent Button(int button, bool pressed) {
    return {Kind::kButton, button, pressed, 0, 0, 0};
  }
  static InputEvent Wheel(double notches) { return {Kind::kWheel, 0, false, 0, 0, notches}; }
};

}  // namespace enamel::station::render
