#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "station/desk/pages.h"
#include "station/render/revolve.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kHead = IM_COL32(150, 170, 205, 255), kShank = IM_COL32(112, 122, 138, 255),
                kScale = IM_COL32(235, 238, 242, 255);

// A body of revolution with this half outline, on its side.
void DrawOutline(const std::vector<glm::vec2>& outline, ImVec2 tip, float mm, ImU32 colour) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (size_t i = 0; i + 1 < outline.size(); ++i) {
    glm::vec2 a = outline[i] * mm, b = outline[i + 1] * mm;
    list->AddQuadFilled({tip.x + a.y, tip.y - a.x}, {tip.x + b.y, tip.y - b.x},
                        {tip.x + b.y, tip.y + b.x}, {tip.x + a.y, tip.y + a.x}, colour);
  }
}

}  // namespace

std::string BurText(const Words& words, const cutting::Bur& bur) {
  const std::string shape = "bur." + std::string(cutting::BurShapeName(bur.shape));
  return words.Say("bur.text", {{"shape", words.Say(shape)},
                                {"thick", words.Decimal(2e3 * bur.radius_m, 1)},
                                {"long", words.Decimal(1e3 * bur.height_m(), 1)}});
}

void DrawBur(const cutting::Bur& bur, float width_px, float height_px, float mm) {
  ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImVec2 tip{at.x + 12, at.y + 0.42f * height_px};
  // A shank may be longer than the page is wide; the head matters.
  list->PushClipRect(at, {at.x + width_px, at.y + height_px}, true);
  DrawOutline(render::BurShankOutline(bur), tip, mm, kShank);
  DrawOutline(render::BurHeadOutline(bur), tip, mm, kHead);
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

}  // namespace enamel::station::desk
