#include "station/render/keyboard.h"

#include <cctype>

namespace enamel::station::render {

int Keyboard::At(int place) const {
  // On every keyboard the space bar, the keypad and the keys that write nothing are where GLFW says.
  const bool writes = place > kKeySpace && place <= '`';
  if (!writes || (place >= '0' && place <= '9')) return place;
  const char* text = printed_(place);
  if (text == nullptr || text[0] == '\0' || text[1] != '\0') return place;
  const auto c = static_cast<unsigned char>(text[0]);
  return std::isgraph(c) != 0 && c < 0x80 ? std::toupper(c) : place;
}

InputEvent Keyboard::Event(int place, bool pressed, int mods, bool repeat) {
  InputEvent event = InputEvent::Key(place, pressed, mods, repeat);
  event.place = place;
  if (place < 0 || place >= kPlaces) return event;
  int& held = held_[static_cast<size_t>(place)];
  if (pressed && held == 0) held = At(place);
  if (held != 0) event.code = held;
  if (!pressed) held = 0;
  return event;
}

}  // namespace enamel::station::render
