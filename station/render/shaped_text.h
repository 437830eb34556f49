#pragma once

#include <imgui.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>

#include "station/render/fonts.h"

// Text in lines, in any script. Dear ImGui draws letter beside letter, which is right for the
// languages of our own texts. Names, titles and remarks come in other scripts too: Arabic joins its
// letters from right to left, Thai and Devanagari stack marks. A text with a letter that its ImFont
// lacks is therefore shaped by Pango, in the fonts that the system has, and drawn as one picture.
namespace enamel::station::render {

// The pictures of shaped texts, kept while they are shown. Needs the OpenGL context current, also
// when destroyed. The first text in a script takes some frames' time, because Pango looks for a font
// and reads it. Its first choice is DejaVu Sans, whatever ENAMEL_FONT names. Not thread-safe.
class ShapedTexts {
 public:
  // A text's picture: white, with the letters' coverage as its alpha. Pixels.
  struct Block {
    unsigned texture = 0;
    float width = 0, height = 0;                       // of the lines
    float ink_x = 0, ink_y = 0, ink_w = 0, ink_h = 0;  // of the picture, from the lines' corner
    int missing = 0;                                   // letters that no font has
    uint64_t frame = 0;                                // in which it was last asked for
  };

  ShapedTexts();
  ~ShapedTexts();
  ShapedTexts(const ShapedTexts&) = delete;
  ShapedTexts& operator=(const ShapedTexts&) = delete;

  // `capital_px`: height of the capitals. `wrap_px`: longest line; 0: only the text's own ends. The
  // text has to be valid UTF-8. The reference holds until NextFrame.
  const Block& Of(const std::string& text, float capital_px, bool bold, float wrap_px);
  // Once a frame, after the last was drawn: forgets what it did not show, where there is much.
  void NextFrame();
  // How many pictures were made so far.
  uint64_t made() const { return made_; }

 private:
  Block Make(const std::string& text, float capital_px, bool bold, float wrap_px);

  struct Pango;  // its objects
  std::unique_ptr<Pango> pango_;
  std::map<std::tuple<std::string, float, bool, float>, Block> blocks_;
  uint64_t frame_ = 0, made_ = 0;
};

// `font` has a shape for each letter of this text. True also of a text that is not valid UTF-8, which
// Dear ImGui shows with substitutes.
bool HasLetters(const ImFont& font, std::string_view text);

// Size of `text`, px, in lines of at most `wrap` px (InLines); 0: only its own.
ImVec2 SizeOf(const Fonts& fonts, const ImFont& font, const std::string& text, float wrap = 0);
// Draws `text` with its upper left corner at `at`, and returns its size.
ImVec2 Draw(const Fonts& fonts, ImDrawList& list, const ImFont& font, const ImVec2& at,
            ImU32 colour, const std::string& text, float wrap = 0);
// Draws `text` at the cursor of the current ImGui window, as an item, in the font and colour in use.
// `even`: in lines of about the same length (InEvenLines).
void Write(const Fonts& fonts, const std::string& text, float wrap = 0, bool even = false);

}  // namespace enamel::station::render
