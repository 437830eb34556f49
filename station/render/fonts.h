#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/language/words.h"

struct ImFont;

// Fonts in the sizes the station needs. Text to be read from two metres (titles, score, timer,
// warnings, buttons) has capitals of kFarCapital_mm; the rest is read from the chair.
namespace enamel::station::render {

inline constexpr double kFarCapital_mm = 12;
// Pixel of a 24-inch screen of 1920 x 1080: 24 in * 25.4 / hypot(1920, 1080).
inline constexpr double kReferencePixel_mm = 0.27673;
// Height of the picture for which sizes are given; others are in proportion.
inline constexpr double kReferenceHeight_px = 1080;

struct Fonts {
  ImFont* near = nullptr;   // operator panel, hints
  ImFont* text = nullptr;   // instructions, reasons
  ImFont* far = nullptr;    // to be read from 2 m
  ImFont* score = nullptr;  // digits only
  float scale = 1;          // picture height / kReferenceHeight_px
};

// Height of a font's capitals, px, from the outline of its letter H. 0 if it has none.
float CapitalHeight_px(const ImFont& font);

// The font's file: DejaVu where Linux distributions put it, or the file named by ENAMEL_FONT. None:
// Dear ImGui's own bitmap font is used, enlarged.
std::optional<std::filesystem::path> FindFont(bool bold = false);
// The file of a Chinese font: Noto Sans CJK (Debian: fonts-noto-cjk), or the file named by
// ENAMEL_CJK_FONT. None: Chinese is not offered.
std::optional<std::filesystem::path> FindChineseFont();

// Makes fonts for pictures of this height with the letters of this language, in the current ImGui
// context, whose textures must then be rebuilt (Screen does). Chinese has the 2500 commonest
// letters and those of our own texts: names with rarer ones show a question mark. `more`: text by
// others, in any script these files have; missing letters (emoji) show as a question mark. Not
// thread-safe.
Fonts MakeFonts(int picture_height_px, language::Language language, std::string_view more = {});

// Whether a text has letters beyond the Latin set.
bool NeedsMoreLetters(std::string_view text);

}  // namespace enamel::station::render
