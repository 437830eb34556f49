#include "station/render/lines.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/utf8.h"

namespace enamel::station::render {
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

auto AdvanceOf(const ImFont& font) {
  return [&](uint32_t code) { return font.GetCharAdvance(static_cast<ImWchar>(code)); };
}

// Whether no letter comes after this in its paragraph.
bool Ends(std::string_view rest) {
  while (!rest.empty()) {
    const uint32_t code = NextCodePoint(rest).value_or(0);
    if (code == '\n') return true;
    if (!Closes(code)) return false;
  }
  return true;
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
        const size_t end = out.find_last_not_of(' ', place - 1) + 1;
        out.replace(end, place - end, 1, '\n');
      } else {
        out.insert(place, 1, '\n');
      }
      x = after;
      place = 0;
    }
    std::string_view following = text;
    const uint32_t next = following.empty() ? 0 : NextCodePoint(following).value_or(0xFFFD);
    if (next != 0 && MayBreak(before, here, next) && !(IsWide(next) && Ends(following))) {
      place = out.size();
      after = 0;
    }
    before = here;
  }
  return out;
}

std::string InLines(std::string_view text, float width, const ImFont& font) {
  return InLines(text, width, AdvanceOf(font));
}

std::string InEvenLines(std::string_view text, float width,
                        const std::function<float(uint32_t code)>& advance) {
  constexpr float kClose = 0.5f;  // less moves no letter by a pixel
  const auto breaks = [](const std::string& lines) { return std::ranges::count(lines, '\n'); };
  std::string out = InLines(text, width, advance);
  for (float low = 0, high = width; high - low > kClose;) {
    const float middle = 0.5f * (low + high);
    std::string narrower = InLines(text, middle, advance);
    if (breaks(narrower) > breaks(out)) {
      low = middle;
    } else {
      high = middle;
      out = std::move(narrower);
    }
  }
  return out;
}

std::string InEvenLines(std::string_view text, float width, const ImFont& font) {
  return InEvenLines(text, width, AdvanceOf(font));
}

void FitNextWindow(float width, float height) {
  // In whole pixels, as ImGui counts the content.
  ImGui::SetNextWindowContentSize({std::ceil(width), std::ceil(height)});
}

}  // namespace enamel::station::render
