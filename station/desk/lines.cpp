#include "station/desk/lines.h"

#include <optional>

#include "common/base/utf8.h"

namespace enamel::station::desk {
namespace {

bool IsDigit(uint32_t code) { return code >= '0' && code <= '9'; }
// Letters that are written without spaces, and the marks among them.
bool IsWide(uint32_t code) { return code >= 0x2E80 && code <= 0xFFEF; }
bool Opens(uint32_t code) {
  return std::u32string_view(U"（“‘《「(").find(static_cast<char32_t>(code)) !=
         std::u32string_view::npos;
}
bool Closes(uint32_t code) {
  return std::u32string_view(U"，。；：！？）”’》」、…,.;:!?)%")
             .find(static_cast<char32_t>(code)) != std::u32string_view::npos;
}

// Whether a line may end after `here`.
bool MayBreak(uint32_t before, uint32_t here, uint32_t next) {
  if (here == ' ') return !IsDigit(before) && next != ' ';
  return (IsWide(here) || IsWide(next)) && !Opens(here) && !Closes(next) && here != ' ' &&
         next != ' ' && !(IsDigit(here) && IsDigit(next));
}

}  // namespace

std::string InLines(std::string_view text, float width,
                    const std::function<float(uint32_t code)>& advance) {
  std::string out;
  size_t place = 0;        // in `out`, after which the line may end; 0: nowhere yet
  float x = 0, after = 0;  // of the line; of it, what is behind `place`
  uint32_t before = 0;
  while (!text.empty()) {
    const std::string_view rest = text;
    const std::optional<uint32_t> code = NextCodePoint(text);
    if (!code) text.remove_prefix(1);
    const uint32_t here = code.value_or(0xFFFD);
    out += rest.substr(0, rest.size() - text.size());
    if (here == '\n') {
      place = 0;
      x = after = 0;
      before = here;
      continue;
    }
    const float step = advance(here);
    x += step;
    after += step;
    // A space at a line's end takes no room.
    if (x > width && place > 0 && here != ' ') {
      if (out[place - 1] == ' ') {
        out[place - 1] = '\n';
      } else {
        out.insert(place, 1, '\n');
      }
      x = after;
      place = 0;
    }
    std::string_view following = text;
    const uint32_t next = following.empty() ? 0 : NextCodePoint(following).value_or(0xFFFD);
    if (next != 0 && MayBreak(before, here, next)) {
      place = out.size();
      after = 0;
    }
    before = here;
  }
  return out;
}

}  // namespace enamel::station::desk
