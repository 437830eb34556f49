#pragma once

#include <cstdint>

namespace enamel::station::render {

// Keys, mouse buttons and modifiers by GLFW's numbers (letters and digits by ASCII, and by what is
// printed on them: keyboard.h), for code that does not draw; screen.cpp checks that they match.
enum Key : int {
  kKeySpace = 32,
  kKeyEscape = 256,
  kKeyEnter = 257,
  kKeyTab = 258,
  kKeyBackspace = 259,
  kKeyRight = 262,
  kKeyLeft = 263,
  kKeyDown = 264,
  kKeyUp = 265,
  kKeyF1 = 290,
  kKeyPadEnter = 335,
  kKeyLeftShift = 340,
  kKeyLeftControl = 341,
  kKeyRightShift = 344,
  kKeyRightControl = 345,
};
enum MouseButton : int { kMouseLeft = 0, kMouseRight = 1, kMouseMiddle = 2 };
inline constexpr int kModShift = 1;

// One action of a person at the window. All input enters this way, from GLFW or from a script that
// plays a person (Screen::Inject), so both are handled alike.
struct InputEvent {
  enum class Kind : uint8_t { kKey, kCharacter, kCursor, kButton, kWheel, kFocus, kPlaced };
  Kind kind = Kind::kKey;
  int code = 0;          // Key or MouseButton; character: Unicode
  bool pressed = false;  // key, button; focus: the window has it now
  int mods = 0;          // kModShift
  bool repeat = false;   // key: pressed, as a repeat of a held key
  int place = 0;         // key: GLFW's number; 0: a script's, which has no keyboard
  double x = 0, y = 0;   // cursor: window pixels from the upper left; wheel: notches

  static InputEvent Key(int key, bool pressed, int mods = 0, bool repeat = false) {
    return {Kind::kKey, key, pressed, mods, repeat, 0, 0, 0};
  }
  static InputEvent Character(int unicode) {
    return {Kind::kCharacter, unicode, true, 0, false, 0, 0, 0};
  }
  static InputEvent Cursor(double x, double y) {
    return {Kind::kCursor, 0, false, 0, false, 0, x, y};
  }
  static InputEvent Button(int button, bool pressed) {
    return {Kind::kButton, button, pressed, 0, false, 0, 0, 0};
  }
  static InputEvent Wheel(double notches) {
    return {Kind::kWheel, 0, false, 0, false, 0, 0, notches};
  }
  // The keyboard goes to this window, or to another from now on.
  static InputEvent Focus(bool here) { return {Kind::kFocus, 0, here, 0, false, 0, 0, 0}; }
  // The next kCursor is where the window system puts the cursor: no hand moves it there.
  static InputEvent Placed() { return {Kind::kPlaced, 0, false, 0, false, 0, 0, 0}; }
};

}  // namespace enamel::station::render
