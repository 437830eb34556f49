#include "station/desk/stop_sign.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <numbers>

#include "station/render/lines.h"
#include "station/render/panel.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kWrong = IM_COL32(176, 38, 28, 255), kCalm = IM_COL32(52, 96, 138, 255),
                kInk = IM_COL32(245, 246, 248, 255), kStopBehind = IM_COL32(12, 14, 17, 225);
// Shares of the picture's height. A stroke is 7 % of the two thirds of the sign that its symbol has:
// 2.8 mm on a screen 300 mm high, 9 arc minutes from a metre. Normal sight resolves 1.
constexpr float kStopSign = 0.2f, kStopTop = 0.36f, kStopApart = 0.45f;  // apart: of the sign

// A square from (0, 0) to (1, 1), y down.
class Pen {
 public:
  Pen(const Rect& at, ImU32 colour)
      : list_(ImGui::GetWindowDrawList()),
        at_(at),
        side_(std::min(at.x1 - at.x0, at.y1 - at.y0)),
        colour_(colour) {}

  ImVec2 At(float x, float y) const { return {at_.x0 + x * side_, at_.y0 + y * side_}; }
  void Box(float x0, float y0, float x1, float y1) const {
    list_->AddRectFilled(At(x0, y0), At(x1, y1), colour_, 0.02f * side_);
  }
  void Line(float x0, float y0, float x1, float y1, float thick = 0.07f) const {
    list_->AddLine(At(x0, y0), At(x1, y1), colour_, thick * side_);
  }
  void Disc(float x, float y, float radius) const {
    list_->AddCircleFilled(At(x, y), radius * side_, colour_, 48);
  }
  void Arc(float x, float y, float radius, float from, float to) const {
    list_->PathArcTo(At(x, y), radius * side_, from, to, 32);
    list_->PathStroke(colour_, 0, 0.07f * side_);
  }
  // An ellipse as wide as a drum seen from a little above; `down`: its lower half alone.
  void Rim(float y, bool down, bool filled) const {
    constexpr float kWide = 0.32f, kHigh = 0.11f, kPi = std::numbers::pi_v<float>;
    constexpr int kSides = 32;
    // A place that comes twice would have a spike.
    for (int i = 0; i < (down ? kSides + 1 : kSides); ++i) {
      const float angle = (down ? kPi : 2 * kPi) * static_cast<float>(i) / kSides;
      list_->PathLineTo(At(0.5f + kWide * std::cos(angle), y + kHigh * std::sin(angle)));
    }
    filled ? list_->PathFillConvex(colour_) : list_->PathStroke(colour_, 0, 0.05f * side_);
  }
  void Triangle(ImVec2 a, ImVec2 b, ImVec2 c) const {
    list_->AddTriangleFilled(At(a.x, a.y), At(b.x, b.y), At(c.x, c.y), colour_);
  }

 private:
  ImDrawList* list_;
  const Rect at_;
  const float side_;
  const ImU32 colour_;
};

// `gap`: between its two halves.
void DrawPlug(const Pen& pen, float gap) {
  const float left = 0.44f - gap / 2, right = 0.44f + gap / 2;
  pen.Line(0.04f, 0.5f, left - 0.2f, 0.5f);
  pen.Box(left - 0.22f, 0.24f, left, 0.76f);
  if (gap > 0) {
    pen.Line(left, 0.38f, left + 0.1f, 0.38f);
    pen.Line(left, 0.62f, left + 0.1f, 0.62f);
  }
  pen.Box(right + 0.06f, 0.18f, right + 0.3f, 0.82f);
  pen.Line(right + 0.28f, 0.5f, 0.96f, 0.5f);
}

// Of a person: call the instructor.
void DrawPerson(const Pen& pen) {
  pen.Disc(0.5f, 0.3f, 0.16f);
  pen.Triangle({0.5f, 0.36f}, {0.16f, 0.86f}, {0.84f, 0.86f});
}

// Up and out: of the holder, or of the tooth.
void DrawLift(const Pen& pen) {
  pen.Line(0.28f, 0.9f, 0.28f, 0.6f);
  pen.Line(0.72f, 0.9f, 0.72f, 0.6f);
  pen.Line(0.26f, 0.9f, 0.74f, 0.9f);
  pen.Line(0.5f, 0.72f, 0.5f, 0.22f);
  pen.Triangle({0.5f, 0.04f}, {0.34f, 0.28f}, {0.66f, 0.28f});
}

// `gaps`: in the colour of the disc below.
void DrawSymbol(Stop stop, const Pen& pen, const Pen& gaps) {
  constexpr float kPi = std::numbers::pi_v<float>;
  switch (stop) {
    case Stop::kNone:
      return;
    case Stop::kUnplugged:
      return DrawPlug(pen, 0.2f);
    case Stop::kPower:
      pen.Arc(0.5f, 0.54f, 0.3f, -0.3f * kPi, 1.3f * kPi);
      return pen.Line(0.5f, 0.14f, 0.5f, 0.5f);
    case Stop::kBusy:  // a glass with sand
      pen.Line(0.26f, 0.14f, 0.74f, 0.14f);
      pen.Line(0.26f, 0.86f, 0.74f, 0.86f);
      pen.Triangle({0.3f, 0.18f}, {0.7f, 0.18f}, {0.5f, 0.52f});
      return pen.Triangle({0.3f, 0.82f}, {0.7f, 0.82f}, {0.5f, 0.48f});
    case Stop::kHolder:  // lies in it
      pen.Line(0.12f, 0.44f, 0.88f, 0.44f);
      pen.Line(0.26f, 0.48f, 0.26f, 0.8f);
      pen.Line(0.74f, 0.48f, 0.74f, 0.8f);
      return pen.Line(0.24f, 0.8f, 0.76f, 0.8f);
    case Stop::kDisk:  // a drum
      pen.Rim(0.18f, false, true);
      pen.Box(0.18f, 0.18f, 0.82f, 0.82f);
      pen.Rim(0.82f, false, true);
      gaps.Rim(0.2f, true, false);
      gaps.Rim(0.42f, true, false);
      return gaps.Rim(0.64f, true, false);
    case Stop::kPaused:
      pen.Box(0.28f, 0.2f, 0.43f, 0.8f);
      return pen.Box(0.57f, 0.2f, 0.72f, 0.8f);
  }
}

using Sketch = void (*)(const Pen&);
// What to do, in order; null: no more.
std::array<Sketch, 2> StepsOf(Stop stop) {
  switch (stop) {
    case Stop::kUnplugged:
      return {[](const Pen& pen) { DrawPlug(pen, 0); }, DrawLift};
    case Stop::kPower:
      return {[](const Pen& pen) { DrawPlug(pen, 0); }, DrawLift};
    case Stop::kBusy:
      return {DrawLift, nullptr};
    case Stop::kHolder:
      return {DrawLift, nullptr};
    case Stop::kDisk:
      return {DrawPerson, nullptr};
    case Stop::kNone:
    case Stop::kPaused:
      break;
  }
  return {nullptr, nullptr};
}

bool IsWrong(Stop stop) { return stop != Stop::kHolder && stop != Stop::kPaused; }

}  // namespace

Stop StopOf(Fault fault, bool put_down, bool disk_full) {
  switch (fault) {
    case Fault::kStalled:
    case Fault::kTooSlow:
    case Fault::kUnplugged:
      return Stop::kUnplugged;
    case Fault::kSwitchedOff:
      return Stop::kPower;
    case Fault::kLateOnce:
    case Fault::kLateOften:
      return Stop::kBusy;
    case Fault::kNone:
      break;
  }
  if (disk_full) return Stop::kDisk;
  return put_down ? Stop::kHolder : Stop::kNone;
}

void DrawStopSign(Stop stop, const Rect& at) {
  const float side = std::min(at.x1 - at.x0, at.y1 - at.y0), inset = 0.17f * side;
  const ImU32 colour = IsWrong(stop) ? kWrong : kCalm;
  Pen(at, colour).Disc(0.5f, 0.5f, 0.5f);
  const Rect inner{at.x0 + inset, at.y0 + inset, at.x0 + side - inset, at.y0 + side - inset};
  DrawSymbol(stop, Pen(inner, kInk), Pen(inner, colour));
}

void DrawStop(Stop stop, const std::string& held, const render::Fonts& fonts,
              const render::Canvas& canvas) {
  if (stop == Stop::kNone) return;
  const auto h = static_cast<float>(canvas.height);
  const render::Span free = render::BesidePanel(fonts, canvas);
  const auto steps = StepsOf(stop);
  size_t count = 0;
  while (count < steps.size() && steps[count] != nullptr) ++count;
  // On an upright screen beside the panel, not as high.
  const float widths = 1 + (1 + kStopApart) * static_cast<float>(count);
  const float side = std::min(kStopSign * h, 0.9f * (free.to - free.from) / widths),
              apart = kStopApart * side, drawn = widths * side;
  const std::string lines = render::InEvenLines(held, 0.8f * (free.to - free.from), *fonts.far);
  const ImVec2 below = fonts.far->CalcTextSizeA(fonts.far->FontSize, FLT_MAX, 0, lines.c_str());
  ImGui::SetNextWindowPos({free.middle(), kStopTop * h}, ImGuiCond_Always, {0.5f, 0});
  render::FitNextWindow(std::max(drawn, below.x),
                        held.empty() ? side : side + ImGui::GetStyle().ItemSpacing.y + below.y);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImGui::ColorConvertU32ToFloat4(kStopBehind));
  ImGui::Begin("stop", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoNav |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::Dummy({drawn, side});
  DrawStopSign(stop, {at.x, at.y, at.x + side, at.y + side});
  for (size_t i = 0; i < count; ++i) {
    at.x += side;
    const Pen arrow(
        {at.x, at.y + 0.5f * (side - apart), at.x + apart, at.y + 0.5f * (side + apart)}, kInk);
    arrow.Triangle({0.8f, 0.5f}, {0.3f, 0.2f}, {0.3f, 0.8f});
    at.x += apart;
    steps[i](Pen({at.x, at.y, at.x + side, at.y + side}, kInk));
  }
  if (!held.empty()) {
    ImGui::PushFont(fonts.far);
    ImGui::TextUnformatted(lines.c_str());
    ImGui::PopFont();
  }
  ImGui::End();
  ImGui::PopStyleColor();
}

}  // namespace enamel::station::desk
