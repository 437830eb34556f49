#include "station/render/fonts.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/base/file.h"

namespace enamel::station::render {
namespace {

namespace fs = std::filesystem;

// Heights of capitals at the reference height, px: 12 mm of a 24-inch screen, and the size that
// looks like 12 mm at 2 m from 0.9 m.
constexpr double kFarCapital_px = kFarCapital_mm / kReferencePixel_mm + 0.7;  // hinting rounds
constexpr double kTextCapital_px = 23, kNearCapital_px = 16, kScoreCapital_px = 150;
constexpr double kLinesOfAPage = 37;
// Pixels of monitors that exist, from a telephone's to a wall's.
constexpr double kMinPixel_mm = 0.05, kMaxPixel_mm = 1.5, kMaxOblong = 1.25;
// Some monitors report a ratio instead of their size: 16:9 or 16:10, in mm, cm or dm. The window
// manager mutter ignores these figures as well.
constexpr int kRatios_mm[][2] = {{16, 9},    {16, 10},    {160, 90},
                                 {160, 100}, {1600, 900}, {1600, 1000}};

// Latin with the signs of names and our texts: accents, Turkish and Polish, dashes, quotes, µ, ²,
// ³, ≥.
constexpr ImWchar kLatin[] = {0x20,   0x17f,  0x218,  0x21b,  0x2010, 0x2026,
                              0x2190, 0x2193, 0x2264, 0x2265, 0};
constexpr size_t kMaxFontBytes = size_t{64} << 20;
// Languages' own names, for choosing one.
constexpr ImWchar kNamesOfLanguages[] = {0x4e2d, 0x4e2d, 0x6587, 0x6587, 0};
constexpr ImWchar kDigits[] = {0x20, 0x20, 0x2d, 0x39, 0x2013, 0x2013, 'H', 'H', 0};

// Font size at which capitals are `capital_px` high, measured on the font itself.
float SizeFor(const fs::path* file, double capital_px, int number = 0) {
  constexpr float kProbe_px = 64;
  ImFontAtlas atlas;
  constexpr ImWchar only_h[] = {'H', 'H', 0};
  ImFont* font = nullptr;
  if (file != nullptr) {
    ImFontConfig config;
    config.FontNo = number;
    font = atlas.AddFontFromFileTTF(file->c_str(), kProbe_px, &config, only_h);
  } else {
    ImFontConfig config;
    config.SizePixels = kProbe_px;
    font = atlas.AddFontDefault(&config);
  }
  if (font == nullptr || !atlas.Build()) return static_cast<float>(capital_px / 0.63);
  float capital = CapitalHeight_px(*font);
  return capital > 0 ? static_cast<float>(kProbe_px * capital_px / capital)
                     : static_cast<float>(capital_px / 0.63);
}

// A file with Chinese letters. It has 20 MB, so it is read once for all sizes.
struct ChineseFont {
  std::vector<uint8_t> bytes;
  int number = 0;            // of the shapes in the file
  float per_capital_px = 0;  // font size for a capital of 1 px
};

std::optional<ChineseFont> ReadChineseFont() {
  const std::optional<fs::path> file = FindChineseFont();
  if (!file) return std::nullopt;
  auto bytes = ReadFile(*file, kMaxFontBytes);
  if (!bytes.ok()) return std::nullopt;
  // One file has the shapes of several countries; the third are those of simplified Chinese.
  ChineseFont font{std::move(*bytes), file->extension() == ".ttc" ? 2 : 0, 0};
  font.per_capital_px = SizeFor(&*file, 1, font.number);
  return font;
}

// Adds Chinese letters, as large as the Latin ones, to the font added last. `font` stays until the
// atlas is built.
void AddChinese(ChineseFont& font, double capital_px, const ImWchar* ranges) {
  ImFontConfig config;
  config.MergeMode = true;
  config.OversampleH = 1;
  config.FontNo = font.number;
  config.FontDataOwnedByAtlas = false;
  ImGui::GetIO().Fonts->AddFontFromMemoryTTF(
      font.bytes.data(), static_cast<int>(font.bytes.size()),
      std::ceil(font.per_capital_px * static_cast<float>(capital_px)), &config, ranges);
}

// The commonest, and all in our texts. Kept until the atlas is built, by ImGui's rule.
const ImWchar* ChineseRanges() {
  static const ImVector<ImWchar> kRanges = [] {
    ImFontGlyphRangesBuilder builder;
    builder.AddRanges(ImGui::GetIO().Fonts->GetGlyphRangesChineseSimplifiedCommon());
    for (const language::Message& m : language::MessagesOf(language::Language::kChinese)) {
      builder.AddText(m.pattern.c_str());
    }
    ImVector<ImWchar> ranges;
    builder.BuildRanges(&ranges);
    return ranges;
  }();
  return kRanges.Data;
}

ImFont* Add(const fs::path* file, double capital_px, const ImWchar* ranges) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  float size = std::ceil(SizeFor(file, capital_px));
  ImFontConfig config;
  config.OversampleH = size > 40 ? 1 : 2;
  config.OversampleV = 1;
  if (file != nullptr) return atlas.AddFontFromFileTTF(file->c_str(), size, &config, ranges);
  config.SizePixels = size;
  return atlas.AddFontDefault(&config);
}

}  // namespace

float CapitalHeight_px(const ImFont& font) {
  const ImFontGlyph* glyph = font.FindGlyphNoFallback('H');
  return glyph != nullptr ? glyph->Y1 - glyph->Y0 : 0;
}

std::optional<fs::path> FindFont(bool bold) {
  std::error_code none;
  if (const char* set = std::getenv("ENAMEL_FONT"); set != nullptr && fs::exists(set, none)) {
    return fs::path(set);
  }
  const char* file = bold ? "DejaVuSans-Bold.ttf" : "DejaVuSans.ttf";
  for (const char* folder :
       {"/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/TTF", "/usr/share/fonts/dejavu",
        "/usr/share/fonts/dejavu-sans-fonts", "/usr/local/share/fonts"}) {
    fs::path path = fs::path(folder) / file;
    if (fs::exists(path, none)) return path;
  }
  return std::nullopt;
}

std::optional<fs::path> FindChineseFont() {
  std::error_code none;
  if (const char* set = std::getenv("ENAMEL_CJK_FONT"); set != nullptr) {
    return fs::exists(set, none) ? std::optional<fs::path>(set) : std::nullopt;
  }
  for (const char* path : {"/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                           "/usr/share/fonts/noto-cjk/NotoSansCJK-Regular.ttc",
                           "/usr/share/fonts/google-noto-cjk/NotoSansCJK-Regular.ttc"}) {
    if (fs::exists(path, none)) return fs::path(path);
  }
  return std::nullopt;
}

LetterSizes LettersFor(int width_px, int height_px, double pixel_mm) {
  const double height_of_4_3 = std::max(std::min<double>(height_px, 0.75 * width_px), 240.0);
  const double seat = std::min(kSeatCapital_mm / pixel_mm, height_of_4_3 / kLinesOfAPage);
  LetterSizes out;
  out.scale = height_of_4_3 / kReferenceHeight_px;
  out.near = std::max(kNearCapital_px * out.scale, seat);
  out.text = std::max(kTextCapital_px * out.scale, out.near);
  out.far = std::max(kFarCapital_px * out.scale, out.text);
  out.score = kScoreCapital_px * out.scale;
  return out;
}

double PixelOf_mm(int width_px, int height_px, int width_mm, int height_mm) {
  const double across = static_cast<double>(width_mm) / std::max(width_px, 1),
               down = static_cast<double>(height_mm) / std::max(height_px, 1);
  const bool ratio = std::ranges::any_of(
      kRatios_mm, [&](const auto& r) { return r[0] == width_mm && r[1] == height_mm; });
  const auto exists = [](double mm) { return mm >= kMinPixel_mm && mm <= kMaxPixel_mm; };
  const bool square = across <= kMaxOblong * down && down <= kMaxOblong * across;
  if (!ratio && square && exists(across) && exists(down)) return 0.5 * (across + down);
  return kReferencePixel_mm * kReferenceHeight_px / std::max(std::min(width_px, height_px), 1);
}

Fonts MakeFonts(const LetterSizes& sizes, language::Language language) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  atlas.Flags |= ImFontAtlasFlags_NoPowerOfTwoHeight;
  std::optional<fs::path> plain = FindFont(), bold = FindFont(true);
  const fs::path *text = plain ? &*plain : nullptr, *title = bold ? &*bold : text;
  Fonts fonts;
  fonts.scale = static_cast<float>(sizes.scale);
  fonts.letters = static_cast<float>(sizes.near / kNearCapital_px);
  std::optional<ChineseFont> chinese = ReadChineseFont();
  const bool speaks_it = language == language::Language::kChinese;
  auto add = [&](const fs::path* file, double capital_px, const ImWchar* ranges) {
    ImFont* font = Add(file, capital_px, kLatin);
    if (chinese && ranges != nullptr) AddChinese(*chinese, capital_px, ranges);
    return font;
  };
  const ImWchar* all = speaks_it ? ChineseRanges() : nullptr;
  fonts.near = add(text, sizes.near, all);
  // The choice of a language shows each one's own name in these letters.
  fonts.text = add(text, sizes.text, speaks_it ? all : kNamesOfLanguages);
  fonts.far = add(title, sizes.far, all);
  fonts.score = Add(title, sizes.score, kDigits);
  // Built here, so that the files' bytes can be freed.
  atlas.Build();
  atlas.ClearInputData();
  return fonts;
}

}  // namespace enamel::station::render
