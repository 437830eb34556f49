#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "station/desk/pages.h"
#include "station/render/lines.h"
#include "station/render/revolve.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kHead = IM_COL32(150, 170, 205, 255), kShank = IM_COL32(112, 122, 138, 255),
                kScale = IM_COL32(235, 238, 242, 255), kBehindBurs = IM_COL32(15, 17, 20, 200);

// A body of revolution with this half outline, on its side.
void DrawOutline(const std::vector<glm::vec2>& outline, ImVec2 tip, float mm, ImU32 colour,
                 ImDrawList* list) {
  for (size_t i = 0; i + 1 < outline.size(); ++i) {
    glm::vec2 a = outline[i] * mm, b = outline[i + 1] * mm;
    list->AddQuadFilled({tip.x + a.y, tip.y - a.x}, {tip.x + b.y, tip.y - b.x},
                        {tip.x + b.y, tip.y + b.x}, {tip.x + a.y, tip.y + a.x}, colour);
  }
}

// Of an ISO number's groups: material, shank, shape, grit, size (schemas/exercise.schema.json).
constexpr size_t kGritAt = 12;
constexpr std::array kGrits = {"504", "514", "524", "534", "544"};

bool IsDiamond(const scene::BurSpec& bur) { return bur.iso_number.starts_with("806"); }

}  // namespace

std::string BurText(const Words& words, const cutting::Bur& bur) {
  const std::string shape = "bur." + std::string(cutting::BurShapeName(bur.shape));
  return words.Say("bur.text", {{"shape", words.Say(shape)},
                                {"thick", words.Decimal(2e3 * bur.radius_m, 1)},
                                {"long", words.Decimal(1e3 * bur.height_m(), 1)}});
}

std::string BurText(const Words& words, const scene::BurSpec& bur) {
  std::string text = BurText(words, bur.metric());
  if (bur.iso_number.empty()) return text;
  text = words.Say("bur.numbered", {{"bur", text}, {"number", bur.iso_number}});
  for (const char* grit : kGrits) {
    if (bur.iso_number.substr(kGritAt, 3) != grit || !IsDiamond(bur)) continue;
    text = words.Say("bur.with_grit",
                     {{"bur", text}, {"grit", words.Say("bur.grit_" + std::string(grit))}});
  }
  return text;
}

void DrawBur(const cutting::Bur& bur, float width_px, float height_px, float mm) {
  ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImVec2 tip{at.x + 12, at.y + 0.42f * height_px};
  // A shank may be longer than the page is wide; the head matters.
  list->PushClipRect(at, {at.x + width_px, at.y + height_px}, true);
  DrawOutline(render::BurShankOutline(bur), tip, mm, kShank, list);
  DrawOutline(render::BurHeadOutline(bur), tip, mm, kHead, list);
  // A scale below it: 5 mm.
  float y = at.y + 0.86f * height_px, tick = 0.05f * height_px, length = 5 * mm,
        thick = 0.012f * height_px;
  list->AddLine({tip.x, y}, {tip.x + length, y}, kScale, thick);
  for (int i = 0; i <= 5; ++i) {
    float x = tip.x + static_cast<float>(i) * mm;
    list->AddLine({x, y - tick}, {x, y + tick}, kScale, thick);
  }
  list->AddText({tip.x + length + 0.07f * height_px, y - 0.5f * ImGui::GetFontSize()}, kScale,
                "5 mm");
  list->PopClipRect();
  ImGui::Dummy({width_px, height_px});
}

void DrawBurChoice(const std::vector<scene::BurSpec>& burs, const render::FrameState& state,
                   const Words& words, const render::Fonts& fonts, const render::Canvas& canvas) {
  if (burs.size() < 2) return;
  const auto w = static_cast<float>(canvas.width);
  const float px = fonts.scale, mm = 14 * px, edge = 10 * px;
  const float wide = render::ChoiceWidth(fonts, canvas) - 2 * edge;
  const ImFont* font = fonts.near;
  ImDrawList* list = ImGui::GetForegroundDrawList();
  auto text_of = [&](const std::string& text) {
    return text.empty() ? text : render::InLines(text, wide - 2 * edge, *font);
  };
  auto tall = [&](const std::string& text) {
    return text.empty() ? 0 : font->CalcTextSizeA(font->FontSize, FLT_MAX, 0, text.c_str()).y;
  };
  auto write = [&](const std::string& text, ImVec2 at) {
    list->AddText(font, font->FontSize, at, kScale, text.c_str());
  };
  struct Row {
    cutting::Bur bur;
    std::string text;
    float body = 0;
  };
  // Below the warnings, which are at the top.
  ImVec2 at{canvas.left_handed ? 2 * edge : w - wide - 2 * edge,
            0.3f * static_cast<float>(canvas.height)};
  std::string waits = state.bur_waits ? text_of(words.Say("bur.waits")) : "";
  const size_t current = std::min<size_t>(state.bur, burs.size() - 1);
  std::vector<Row> rows;
  for (const scene::BurSpec& bur : burs) {
    rows.push_back({bur.metric(), text_of(BurText(words, bur)),
                    2e3f * static_cast<float>(bur.metric().radius_m) * mm});
  }
  const auto fits = [&] {
    float height = waits.empty() ? 0 : tall(waits) + 3 * edge;
    for (const Row& row : rows) height += row.body + tall(row.text) + 4 * edge;
    return at.y + height <= canvas.floor;
  };
  // With less room without the others' words, then without the others, then without words.
  for (size_t i = 0; i < rows.size() && !fits(); ++i) {
    if (i != current) rows[i].text.clear();
  }
  size_t first = 0;
  if (!fits()) {
    rows = {rows[current]};
    first = current;
  }
  if (!fits()) rows[0].text.clear();
  if (!fits()) waits.clear();
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const ImVec2 end{at.x + wide, at.y + row.body + tall(row.text) + 3 * edge};
    list->AddRectFilled(at, end, kBehindBurs, edge);
    if (first + i == current) list->AddRect(at, end, kScale, edge, 0, 3 * px);
    const ImVec2 tip{at.x + edge, at.y + edge + 0.5f * row.body};
    list->PushClipRect(at, end, true);
    DrawOutline(render::BurShankOutline(row.bur), tip, mm, kShank, list);
    DrawOutline(render::BurHeadOutline(row.bur), tip, mm, kHead, list);
    list->PopClipRect();
    write(row.text, {at.x + edge, at.y + row.body + 2 * edge});
    at.y = end.y + edge;
  }
  if (waits.empty()) return;
  list->AddRectFilled(at, {at.x + wide, at.y + tall(waits) + 2 * edge}, kBehindBurs, edge);
  write(waits, {at.x + edge, at.y + edge});
}

}  // namespace enamel::station::desk
