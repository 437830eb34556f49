#include "station/render/shaped_text.h"

#include <epoxy/gl.h>
#include <pango/pangoft2.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <optional>
#include <vector>

#include "common/base/utf8.h"
#include "station/render/lines.h"

namespace enamel::station::render {
namespace {

// Height of a capital in DejaVu Sans, as a share of its size: OS/2.sCapHeight / unitsPerEm.
constexpr double kCapitalOfDejaVu = 1493.0 / 2048;
// Some pages of names. NextFrame keeps more than these while a page shows them.
constexpr size_t kKept = 200;
// A texture's longest side; every OpenGL 3.3 allows it.
constexpr int kMaxSide_px = 4096;
constexpr int kEdge_px = 1;  // transparent, so that interpolation takes in no other pixel

// Han letters differ between countries. Without kana, a text of them is taken for simplified Chinese,
// as the window's own.
const char* LanguageOf(std::string_view text) {
  bool han = false;
  while (!text.empty()) {
    const uint32_t code = NextCodePoint(text).value_or(0);
    if (code >= 0x3040 && code <= 0x30FF) return "ja";
    han |= code >= 0x2E80 && code <= 0x9FFF;
  }
  return han ? "zh-cn" : "en";
}

bool IsShaped(const Fonts& fonts, const ImFont& font, const std::string& text) {
  return fonts.shaped != nullptr && !HasLetters(font, text);
}

const ShapedTexts::Block& BlockOf(const Fonts& fonts, const ImFont& font, const std::string& text,
                                  float wrap) {
  return fonts.shaped->Of(text, CapitalHeight_px(font), &font == fonts.far, wrap);
}

std::string Lines(const std::string& text, float wrap, const ImFont& font) {
  return wrap > 0 ? InLines(text, wrap, font) : text;
}

}  // namespace

struct ShapedTexts::Pango {
  PangoFontMap* fonts = pango_ft2_font_map_new();
  PangoContext* context = pango_font_map_create_context(fonts);
  PangoLayout* layout = pango_layout_new(context);

  ~Pango() {
    g_object_unref(layout);
    g_object_unref(context);
    g_object_unref(fonts);
  }
};

ShapedTexts::ShapedTexts() = default;

ShapedTexts::~ShapedTexts() {
  for (const auto& [key, block] : blocks_) glDeleteTextures(1, &block.texture);
}

const ShapedTexts::Block& ShapedTexts::Of(const std::string& text, float capital_px, bool bold,
                                          float wrap_px) {
  auto [found, fresh] = blocks_.try_emplace({text, capital_px, bold, wrap_px});
  if (fresh) found->second = Make(text, capital_px, bold, wrap_px);
  found->second.frame = frame_;
  return found->second;
}

void ShapedTexts::NextFrame() {
  ++frame_;
  if (blocks_.size() <= kKept) return;
  std::erase_if(blocks_, [&](const auto& item) {
    const bool unused = item.second.frame + 1 < frame_;
    if (unused) glDeleteTextures(1, &item.second.texture);
    return unused;
  });
}

ShapedTexts::Block ShapedTexts::Make(const std::string& text, float capital_px, bool bold,
                                     float wrap_px) {
  if (!pango_) pango_ = std::make_unique<Pango>();
  ++made_;
  PangoLayout* layout = pango_->layout;
  PangoFontDescription* font = pango_font_description_from_string("DejaVu Sans");
  pango_font_description_set_absolute_size(font, capital_px / kCapitalOfDejaVu * PANGO_SCALE);
  pango_font_description_set_weight(font, bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
  pango_layout_set_font_description(layout, font);
  pango_font_description_free(font);
  pango_context_set_language(pango_->context, pango_language_from_string(LanguageOf(text)));
  const int wrap = std::min(static_cast<int>(wrap_px), kMaxSide_px - 2 * kEdge_px);
  pango_layout_set_width(layout, wrap > 0 ? wrap * PANGO_SCALE : -1);
  pango_layout_set_wrap(layout, PANGO_WRAP_WORD_CHAR);
  pango_layout_set_text(layout, text.data(), static_cast<int>(text.size()));
  pango_layout_context_changed(layout);

  PangoRectangle ink, lines;
  pango_layout_get_pixel_extents(layout, &ink, &lines);
  Block out;
  out.missing = pango_layout_get_unknown_glyphs_count(layout);
  out.width = static_cast<float>(lines.width);
  out.height = static_cast<float>(lines.height);
  const int w = std::clamp(ink.width + 2 * kEdge_px, 1, kMaxSide_px),
            h = std::clamp(ink.height + 2 * kEdge_px, 1, kMaxSide_px);
  // Lines that run from right to left begin at the right end of their room: they are moved to its left.
  out.ink_x = static_cast<float>(ink.x - lines.x - kEdge_px);
  out.ink_y = static_cast<float>(ink.y - lines.y - kEdge_px);
  out.ink_w = static_cast<float>(w);
  out.ink_h = static_cast<float>(h);
  std::vector<unsigned char> pixels(static_cast<size_t>(w) * static_cast<size_t>(h));
  FT_Bitmap bitmap{};
  bitmap.rows = static_cast<unsigned>(h);
  bitmap.width = static_cast<unsigned>(w);
  bitmap.pitch = w;
  bitmap.buffer = pixels.data();
  bitmap.num_grays = 256;
  bitmap.pixel_mode = FT_PIXEL_MODE_GRAY;
  pango_ft2_render_layout(&bitmap, layout, kEdge_px - ink.x, kEdge_px - ink.y);

  glGenTextures(1, &out.texture);
  glBindTexture(GL_TEXTURE_2D, out.texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, w, h, 0, GL_RED, GL_UNSIGNED_BYTE, pixels.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  constexpr GLint kCoverage[] = {GL_ONE, GL_ONE, GL_ONE, GL_RED};
  glTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_RGBA, kCoverage);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glBindTexture(GL_TEXTURE_2D, 0);
  return out;
}

bool HasLetters(const ImFont& font, std::string_view text) {
  bool all = true;
  while (!text.empty()) {
    const std::optional<uint32_t> code = NextCodePoint(text);
    if (!code) return true;
    all &= *code < 0x20 || (*code <= IM_UNICODE_CODEPOINT_MAX &&
                            font.FindGlyphNoFallback(static_cast<ImWchar>(*code)) != nullptr);
  }
  return all;
}

ImVec2 SizeOf(const Fonts& fonts, const ImFont& font, const std::string& text, float wrap) {
  if (IsShaped(fonts, font, text)) {
    const ShapedTexts::Block& block = BlockOf(fonts, font, text, wrap);
    return {block.width, block.height};
  }
  return font.CalcTextSizeA(font.FontSize, FLT_MAX, wrap, Lines(text, wrap, font).c_str());
}

ImVec2 Draw(const Fonts& fonts, ImDrawList& list, const ImFont& font, const ImVec2& at,
            ImU32 colour, const std::string& text, float wrap) {
  if (!IsShaped(fonts, font, text)) {
    const std::string lines = Lines(text, wrap, font);
    list.AddText(&font, font.FontSize, at, colour, lines.c_str(), nullptr, wrap);
    return font.CalcTextSizeA(font.FontSize, FLT_MAX, wrap, lines.c_str());
  }
  const ShapedTexts::Block& block = BlockOf(fonts, font, text, wrap);
  // On whole pixels, as Pango has placed the letters.
  const ImVec2 lo{std::floor(at.x) + block.ink_x, std::floor(at.y) + block.ink_y};
  list.AddImage(reinterpret_cast<ImTextureID>(static_cast<intptr_t>(block.texture)), lo,
                {lo.x + block.ink_w, lo.y + block.ink_h}, {0, 0}, {1, 1}, colour);
  return {block.width, block.height};
}

void Write(const Fonts& fonts, const std::string& text, float wrap, bool even) {
  const ImFont& font = *ImGui::GetFont();
  if (IsShaped(fonts, font, text)) {
    return ImGui::Dummy(Draw(fonts, *ImGui::GetWindowDrawList(), font, ImGui::GetCursorScreenPos(),
                             ImGui::GetColorU32(ImGuiCol_Text), text, wrap));
  }
  if (wrap <= 0) return ImGui::TextUnformatted(text.c_str());
  // A word longer than the line is cut where the line ends.
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + wrap);
  ImGui::TextUnformatted(
      (even ? InEvenLines(text, wrap, font) : InLines(text, wrap, font)).c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace enamel::station::render
