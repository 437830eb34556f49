#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "common/language/words.h"

struct ImFont;

// Fonts in the sizes the station needs. Text to be read from two metres (titles, score, timer,
// warnings, buttons) has capitals of kFarCapital_mm on a 24-inch screen; the rest is read from the
// chair.
namespace enamel::station::render {

inline constexpr double kFarCapital_mm = 12;
// Pixel of a 24-inch screen of 1920 x 1080: 24 in * 25.4 / hypot(1920, 1080).
inline constexpr double kReferencePixel_mm = 0.27673;
// Height of the picture for which sizes are given; others are in proportion.
inline constexpr double kReferenceHeight_px = 1080;
// The smallest letters, seen from the chair: 22 minutes of arc at 700 mm. ISO 9241-3 and NUREG-0700
// (1.3.1-4) prefer 20 to 22 for reading, and require 16.
inline constexpr double kSeatCapital_mm = 4.480;

// Heights of capitals, px, and the size of all that is given in pixels of the reference picture.
struct LetterSizes {
  double near = 0, text = 0, far = 0, score = 0;
  double scale = 1;  // of the reference picture's pixels
};
// For a window on a screen with pixels of this size. In proportion to the largest picture of 4:3 that
// the window has room for, so that an upright screen keeps its lines; but none smaller than
// kSeatCapital_mm, as far as the window has room for it: 37 of them are the least height of a page.
// Pure.
LetterSizes LettersFor(int width_px, int height_px, double pixel_mm);

// Size of a monitor's pixels from the size that it reports. Where that is missing or cannot be true,
// the shorter side is taken to be as long as a 24-inch screen's. Pure.
double PixelOf_mm(int width_px, int height_px, int width_mm, int height_mm);

class ShapedTexts;

struct Fonts {
  ImFont* near = nullptr;         // operator panel, hints
  ImFont* text = nullptr;         // instructions, reasons
  ImFont* far = nullptr;          // to be read from 2 m
  ImFont* score = nullptr;        // digits only
  float scale = 1;                // LetterSizes::scale
  float letters = 1;              // of `near`, by their size in the reference picture
  ShapedTexts* shaped = nullptr;  // for texts with other letters (shaped_text.h); null: none
};

// Height of a font's capitals, px, from the outline of its letter H. 0 if it has none.
float CapitalHeight_px(const ImFont& font);

// The font's file: DejaVu where Linux distributions put it, or the file named by ENAMEL_FONT. None:
// Dear ImGui's own bitmap font is used, enlarged.
std::optional<std::filesystem::path> FindFont(bool bold = false);
// The file of a Chinese font: Noto Sans CJK (Debian: fonts-noto-cjk), or the file named by
// ENAMEL_CJK_FONT. None: Chinese is not offered.
std::optional<std::filesystem::path> FindChineseFont();

// Makes fonts of these sizes with the letters of this language, in the current ImGui
// context, whose textures must then be rebuilt (Screen does). Chinese has the 2500 commonest
// letters and those of our own texts. Not thread-safe.
Fonts MakeFonts(const LetterSizes& sizes, language::Language language);

}  // namespace enamel::station::render
