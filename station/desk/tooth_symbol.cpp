#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>

#include "common/scene/tooth_number.h"
#include "station/desk/exercise_words.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kLine = IM_COL32(150, 160, 172, 255), kCut = IM_COL32(94, 176, 255, 255),
                kSound = IM_COL32(58, 66, 76, 255), kSoft = IM_COL32(150, 98, 52, 255),
                kNumber = IM_COL32(235, 238, 242, 255);

// A side of the square, or its middle.
enum Field : size_t { kTop, kRight, kBottom, kLeft, kMiddle };

bool IsUpper(int tooth) {
  const int quadrant = tooth / 10;
  return quadrant == 1 || quadrant == 2 || quadrant == 5 || quadrant == 6;
}
// The patient's right is at the chart's left, so mesial points to its middle.
bool IsMesialRight(int tooth) {
  const int quadrant = tooth / 10;
  return quadrant == 1 || quadrant == 4 || quadrant == 5 || quadrant == 8;
}

std::array<bool, 5> CutFields(const Catalogue::Facts& facts) {
  std::array<bool, 5> cut{};
  const auto& landmark = facts.landmark;
  if (landmark == "crown_top") cut.fill(true);
  if (landmark == "occlusal_centre" || landmark == "caries" || landmark == "chamber") {
    cut[kMiddle] = true;
  }
  if (landmark == "mesial_box") cut[IsMesialRight(facts.tooth) ? kRight : kLeft] = true;
  if (landmark == "class_5" || landmark == "labial_face") {
    cut[IsUpper(facts.tooth) ? kTop : kBottom] = true;
  }
  return cut;
}

// The practice block: the shape to cut, from above.
void DrawBlock(const Catalogue::Facts& facts, ImDrawList* list, ImVec2 lo, float side) {
  auto box = [&](float x0, float y0, float x1, float y1, ImU32 colour) {
    list->AddRectFilled({lo.x + x0 * side, lo.y + y0 * side}, {lo.x + x1 * side, lo.y + y1 * side},
                        colour);
  };
  box(0, 0, 1, 1, kSound);
  if (facts.landmark == "circle") {
    list->AddCircleFilled({lo.x + 0.5f * side, lo.y + 0.5f * side}, 0.28f * side, kCut, 32);
  } else if (facts.landmark == "cross") {
    box(0.18f, 0.42f, 0.82f, 0.58f, kCut);
    box(0.42f, 0.18f, 0.58f, 0.82f, kCut);
  } else if (facts.landmark == "line") {
    box(0.14f, 0.43f, 0.86f, 0.57f, kCut);
  } else if (facts.landmark == "step") {
    box(0.18f, 0.34f, 0.5f, 0.66f, IM_COL32(62, 118, 172, 255));
    box(0.5f, 0.34f, 0.82f, 0.66f, kCut);
  } else {
    box(0.28f, 0.36f, 0.72f, 0.64f, kCut);
  }
  list->AddRect(lo, {lo.x + side, lo.y + side}, kLine);
}

}  // namespace

void DrawToothSymbol(const Catalogue::Facts& facts, const Rect& at) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float whole = at.x1 - at.x0;
  if (facts.tooth == 0) return DrawBlock(facts, list, {at.x0, at.y0}, whole);
  const float side = 0.68f * whole, size = 0.30f * whole;
  const ImVec2 lo{at.x0 + 0.5f * (whole - side), at.y0};
  auto point = [&](float x, float y) { return ImVec2{lo.x + x * side, lo.y + y * side}; };
  constexpr float a = 0.3f, b = 0.7f;  // the middle's edges
  const std::array<std::array<ImVec2, 4>, 5> fields = {{
      {point(0, 0), point(1, 0), point(b, a), point(a, a)},
      {point(1, 0), point(1, 1), point(b, b), point(b, a)},
      {point(1, 1), point(0, 1), point(a, b), point(b, b)},
      {point(0, 1), point(0, 0), point(a, a), point(a, b)},
      {point(a, a), point(b, a), point(b, b), point(a, b)},
  }};
  const std::array<bool, 5> cut = CutFields(facts);
  for (size_t i = 0; i < fields.size(); ++i) {
    const auto& [p, q, r, s] = fields[i];
    list->AddQuadFilled(p, q, r, s, cut[i] ? kCut : kSound);
    list->AddQuad(p, q, r, s, kLine, std::max(1.0f, 0.02f * whole));
  }
  if (facts.caries) {
    // Beside the box, at the contact; otherwise below the fossa.
    const float x = !facts.neighbours ? 0.5f : IsMesialRight(facts.tooth) ? 0.88f : 0.12f;
    list->AddCircleFilled(point(x, 0.5f), 0.09f * side, kSoft, 16);
  }
  if (facts.neighbours) {
    for (float x : {-0.12f, 1.12f}) {
      list->AddLine(point(x, 0.15f), point(x, 0.85f), kLine, std::max(1.0f, 0.03f * whole));
    }
  }
  const std::string number = std::to_string(facts.tooth);
  const ImFont* font = ImGui::GetFont();
  const ImVec2 letters = font->CalcTextSizeA(size, whole, 0, number.c_str());
  list->AddText(font, size, {at.x0 + 0.5f * (whole - letters.x), at.y1 - size}, kNumber,
                number.c_str());
}

}  // namespace enamel::station::desk
