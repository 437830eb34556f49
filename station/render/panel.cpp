#include "station/render/panel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "station/render/lines.h"

namespace enamel::station::render {
namespace {

constexpr float kMargin_px = 28, kPanelWidth_px = 505, kBar_px = 20;  // at the reference height
constexpr float kWarningsHeight = 0.3f;  // of the picture, at most in the large letters
constexpr double kShown_mm3 = 0.005;     // less would be shown as 0.00
constexpr ImGuiWindowFlags kOverlay =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

ImVec4 ColourFor(Bearing bearing) {
  auto [r, g, b] = ColourOf(bearing);
  return {r, g, b, 1};
}

// In the order of their bits.
constexpr std::array<const char*, kWarningCount> kWarnings = {
    "warning.press_less", "warning.uneven",  "warning.force_off",  "warning.held_up",
    "warning.offline",    "warning.pulp",    "warning.disk",       "warning.silent",
    "warning.time",       "warning.resumed", "warning.no_realtime"};
const ImVec4 kAlarm{0.60f, 0.13f, 0.10f, 0.94f}, kCalm{0.16f, 0.30f, 0.42f, 0.94f};

struct Panel {
  const PanelContent& c;
  const Words& words;
  const Fonts& fonts;
  float px;  // one pixel of the reference picture

  float width() const { return kPanelWidth_px * px; }

  // The value at the right, a line lower where both have no room in one.
  void Value(const std::string& name, const std::string& value) const {
    const float left = ImGui::GetCursorPosX(), apart = ImGui::GetStyle().ItemSpacing.x,
                value_px = ImGui::CalcTextSize(value.c_str()).x;
    ImGui::TextUnformatted(name.c_str());
    if (ImGui::GetItemRectSize().x + apart + value_px <= width()) ImGui::SameLine();
    ImGui::SetCursorPosX(left + width() - value_px);
    ImGui::TextUnformatted(value.c_str());
  }

  // `mark`: where the bar becomes critical; 0: nowhere.
  void Bar(const char* name, const std::string& value, double share, Bearing bearing,
           double mark = 0) const {
    ImGui::PushFont(fonts.far);
    Value(words.Say(name), value);
    ImGui::PopFont();
    ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ColourFor(bearing));
    ImGui::ProgressBar(static_cast<float>(std::clamp(share, 0.0, 1.0)), {width(), kBar_px * px},
                       "");
    ImGui::PopStyleColor();
    if (mark <= 0) return;
    ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
    float x = lo.x + static_cast<float>(mark) * (hi.x - lo.x);
    ImGui::GetWindowDrawList()->AddLine({x, lo.y - 5 * px}, {x, hi.y + 5 * px},
                                        IM_COL32(255, 255, 255, 255), 3 * px);
  }

  void Time() const {
    std::string text = TimerText(c.state.time_s);
    bool over = c.time_limit_s > 0 && c.state.time_s > c.time_limit_s;
    ImGui::PushFont(fonts.far);
    ImGui::TextColored(over ? ColourFor(Bearing::kBad) : ImVec4{1, 1, 1, 1}, "%s", text.c_str());
    ImGui::PopFont();
    if (c.time_limit_s > 0) {
      ImGui::TextDisabled(
          "%s", words.Say("panel.time_of", {{"time", TimerText(c.time_limit_s)}}).c_str());
    }
  }

  void Force() const {
    double force = glm::length(c.state.force_sent_n);
    // The source of 0.6 and 0.9 is not recorded; only this bar's colour depends on them.
    double share = force / std::max(c.force_full_scale_n, 1e-3);
    Bar("panel.force", words.Decimal(force, 2) + " N", share,
        share < 0.6   ? Bearing::kGood
        : share < 0.9 ? Bearing::kCareful
                      : Bearing::kBad);
  }

  void Zones() const {
    if (!c.zones) return;
    Bar("panel.target", words.Decimal(c.zones->target_percent, 0) + " %",
        c.zones->target_percent / 100, Bearing::kGood);
  }

  // The least remaining leeway, and its used share.
  void Leeway() const {
    if (!c.reach.leeway) return;
    const Reach::Leeway& leeway = *c.reach.leeway;
    bool beyond = leeway.left_mm < 0;
    Bar(beyond ? "panel.over" : "panel.limit", words.Decimal(std::fabs(leeway.left_mm), 2) + " mm",
        beyond || leeway.whole_mm <= 0 ? 1 : leeway.left_mm / leeway.whole_mm, BearingOf(leeway));
    const std::string where = words.Say(leeway.where.empty() ? "panel.until_limit" : leeway.where);
    std::string used;
    if (c.zones && c.zones->neighbour_mm3 >= kShown_mm3) {
      used =
          words.Say("panel.neighbour_cut", {{"volume", words.Decimal(c.zones->neighbour_mm3, 2)}});
    } else if (c.zones && c.zones->beyond_mm3 >= kShown_mm3) {
      used = words.Say("panel.too_much", {{"volume", words.Decimal(c.zones->beyond_mm3, 2)}});
    } else if (c.zones) {
      used =
          words.Say("panel.leeway_used", {{"percent", words.Decimal(c.zones->leeway_percent, 0)}});
    }
    Value(where, used);
  }

  void Pulp() const {
    if (!c.reach.pulp_mm) return;
    double left = *c.reach.pulp_mm;
    const std::string shown =
        left >= kPulpFar_mm ? "> " + words.Decimal(left, 0) : words.Decimal(left, 2);
    Bar("panel.pulp", shown + " mm", left / kPulpFar_mm, BearingOfPulp(left),
        kPulpThin_mm / kPulpFar_mm);
  }

  void Removed() const {
    if (!c.recorded) {
      ImGui::TextUnformatted(words.Say("panel.not_recorded").c_str());
      return;
    }
    bool any = false;
    for (size_t t = 1; t < c.state.removed_mm3.size(); ++t) {
      double mm3 = c.state.removed_mm3[t];
      if (mm3 < 0.005) continue;
      any = true;
      const auto tissue = static_cast<cutting::Tissue>(t);
      Value(words.Say("tissue." + std::string(cutting::TissueName(tissue))),
            words.Decimal(mm3, 2) + " mm³");
    }
    if (!any) Value(words.Say("panel.removed"), words.Say("panel.nothing_yet"));
  }

  void All() const {
    ImGui::PushFont(fonts.near);
    if (!c.heading.empty()) {
      ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + width());
      ImGui::TextDisabled("%s", InLines(c.heading, width(), *fonts.near).c_str());
      ImGui::PopTextWrapPos();
    }
    if (c.has_state) {
      Time();
      ImGui::Spacing();
      Force();
      Zones();
      Leeway();
      Pulp();
      ImGui::Spacing();
      Removed();
    } else {
      ImGui::TextDisabled("%s", words.Say("panel.waiting").c_str());
    }
    ImGui::PopFont();
  }
};

ImVec2 SizeOf(const ImFont& font, const std::string& lines) {
  return font.CalcTextSizeA(font.FontSize, FLT_MAX, 0, lines.c_str());
}

// Ends at the height that is returned.
float DrawWarnings(const PanelContent& content, const Words& words, const Fonts& fonts, float width,
                   float height, float px) {
  const std::string text = WarningText(words, content);
  if (text.empty()) return 0;
  const float left = PanelRight(fonts), widest = width - left - 3 * kMargin_px * px;
  auto lines_of = [&](const ImFont& font) { return InEvenLines(text, widest, font); };
  // Several at a time in smaller letters: the tooth is below them.
  const ImVec2 large = SizeOf(*fonts.far, lines_of(*fonts.far));
  ImFont* font = large.y > kWarningsHeight * height ? fonts.text : fonts.far;
  ImGui::PushFont(font);
  ImGui::SetNextWindowPos({0.5f * (left + width), kMargin_px * px}, ImGuiCond_Always, {0.5f, 0});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {width - left - kMargin_px * px, 1e6f});
  // These are no cause for alarm: nothing is lost, and cutting continues.
  constexpr uint32_t kNoAlarm = kWarnResumed | kWarnOffline;
  const bool calm = content.fault.empty() && (content.state.warnings & ~kNoAlarm) == 0;
  ImGui::PushStyleColor(ImGuiCol_WindowBg, calm ? kCalm : kAlarm);
  ImGui::Begin("warnings", nullptr, kOverlay);
  ImGui::TextUnformatted(lines_of(*font).c_str());
  const float end = ImGui::GetWindowPos().y + ImGui::GetWindowSize().y;
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopFont();
  return end;
}

void DrawScaleBar(double mm_per_pixel, const Fonts& fonts, float width, float height, float px) {
  if (mm_per_pixel <= 0) return;
  auto length = static_cast<float>(1 / mm_per_pixel);
  ImVec2 right{width - kMargin_px * px, height - kMargin_px * px}, left{right.x - length, right.y};
  ImDrawList* list = ImGui::GetForegroundDrawList();
  ImU32 white = IM_COL32(255, 255, 255, 210);
  list->AddLine(left, right, white, 3 * px);
  list->AddLine({left.x, left.y - 9 * px}, {left.x, left.y + 9 * px}, white, 3 * px);
  list->AddLine({right.x, right.y - 9 * px}, {right.x, right.y + 9 * px}, white, 3 * px);
  const ImVec2 text = SizeOf(*fonts.near, "1 mm");
  list->AddText(fonts.near, fonts.near->FontSize,
                {(left.x + right.x - text.x) / 2, left.y - 10 * px - text.y}, white, "1 mm");
}

// At the edge of what warnings and keys leave free, so large that it is found at a glance.
void DrawBurAway(const glm::vec2& away, const Words& words, const Fonts& fonts, float top,
                 float width, float bottom, float px) {
  const float inset = 70 * px, size = 34 * px;
  // Beside the panel, which is at the left.
  const float left_px = PanelRight(fonts);
  const glm::vec2 middle(0.5f * (left_px + width), 0.5f * (top + bottom));
  const float to_side = (0.5f * (width - left_px) - inset) / std::max(std::fabs(away.x), 1e-3f),
              to_top = (0.5f * (bottom - top) - inset) / std::max(std::fabs(away.y), 1e-3f);
  const glm::vec2 tip = middle + away * std::min(to_side, to_top), across(-away.y, away.x);
  const glm::vec2 left = tip - away * (1.6f * size) + across * size,
                  right = tip - away * (1.6f * size) - across * size;
  const auto [r, g, b] = ColourOf(Bearing::kCareful);
  ImDrawList* list = ImGui::GetForegroundDrawList();
  list->AddTriangleFilled({tip.x, tip.y}, {left.x, left.y}, {right.x, right.y},
                          ImGui::ColorConvertFloat4ToU32({r, g, b, 1}));
  const std::string name = words.Say("panel.bur");
  const ImVec2 text = SizeOf(*fonts.far, name);
  const glm::vec2 at =
      tip - away * (2.2f * size + 0.5f * (std::fabs(away.x) * text.x + std::fabs(away.y) * text.y));
  const ImVec2 lo{at.x - 0.5f * text.x, at.y - 0.5f * text.y};
  list->AddRectFilled({lo.x - 10 * px, lo.y}, {lo.x + text.x + 10 * px, lo.y + text.y},
                      IM_COL32(15, 17, 20, 200), 8 * px);
  list->AddText(fonts.far, fonts.far->FontSize, lo, IM_COL32(255, 255, 255, 255), name.c_str());
}

// On its own background, because roots and a neighbour's crown reach down to it. Begins at the height
// that is returned.
float DrawHint(const std::string& spaced, const Fonts& fonts, float width, float height, float px) {
  if (spaced.empty()) return height;
  const float size = fonts.near->FontSize, widest = width - 2 * kMargin_px * px;
  const std::string hint = InEvenLines(Unbroken(spaced), widest, *fonts.near);
  const ImVec2 text = SizeOf(*fonts.near, hint);
  const ImVec2 at{kMargin_px * px, height - kMargin_px * px - text.y};
  ImDrawList* list = ImGui::GetForegroundDrawList();
  list->AddRectFilled({at.x - 12 * px, at.y - 6 * px},
                      {at.x + text.x + 12 * px, at.y + text.y + 6 * px}, IM_COL32(15, 17, 20, 200),
                      8 * px);
  list->AddText(fonts.near, size, at, IM_COL32(214, 220, 228, 255), hint.c_str());
  return at.y;
}

}  // namespace

// Sky blue, yellow, vermilion of the palette of Okabe and Ito (2008).
std::array<float, 3> ColourOf(Bearing bearing) {
  switch (bearing) {
    case Bearing::kGood:
      return {0.34f, 0.71f, 0.91f};
    case Bearing::kCareful:
      return {0.94f, 0.89f, 0.26f};
    case Bearing::kBad:
      return {0.84f, 0.37f, 0.00f};
  }
  return {1, 1, 1};
}

Bearing BearingOf(const Reach::Leeway& leeway) {
  if (leeway.left_mm < 0) return Bearing::kBad;
  return leeway.left_mm < 0.5 * leeway.whole_mm ? Bearing::kCareful : Bearing::kGood;
}

Bearing BearingOfPulp(double left_mm) {
  if (left_mm < kPulpThin_mm) return Bearing::kBad;
  return left_mm < 2 * kPulpThin_mm ? Bearing::kCareful : Bearing::kGood;
}

std::string Unbroken(const std::string& hint) {
  constexpr char kNoBreakSpace[] = "\u00a0";
  std::string out;
  for (size_t i = 0; i < hint.size(); ++i) {
    const bool part = hint[i] == ' ' && i > 0 && i + 1 < hint.size();
    const bool single = part && hint[i - 1] != ' ' && hint[i + 1] != ' ';
    out += single ? kNoBreakSpace : std::string(1, hint[i]);
  }
  return out;
}

std::string TimerText(double seconds) {
  auto s = static_cast<long>(std::max(seconds, 0.0));
  char text[48];
  if (s >= 3600)
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  else
    std::snprintf(text, sizeof text, "%ld:%02ld", s / 60, s % 60);
  return text;
}

std::string WarningText(const Words& words, uint32_t warnings) {
  std::string out;
  if (warnings & kWarnDisk) warnings &= ~kWarnOffline;  // which says that recording continues
  for (size_t i = 0; i < kWarnings.size(); ++i) {
    if (!(warnings >> i & 1)) continue;
    if (!out.empty()) out += '\n';
    out += words.Say(kWarnings[i]);
  }
  return out;
}

std::string WarningText(const Words& words, const PanelContent& content) {
  if (content.fault.empty()) return WarningText(words, content.state.warnings);
  // The fault's own text replaces these two and adds what to do.
  std::string rest = WarningText(words, content.state.warnings & ~(kWarnFault | kWarnDevice));
  return content.fault + (rest.empty() ? "" : "\n" + rest);
}

void HideProgress(PanelContent& content) {
  content.recorded = false;
  content.zones.reset();
  content.reach = {};
  content.state.removed_mm3 = {};
}

float PanelRight(const Fonts& fonts) { return (kPanelWidth_px + 4 * kMargin_px) * fonts.scale; }

void DrawPanel(const PanelContent& content, const Words& words, const Fonts& fonts, int width,
               int height) {
  Panel panel{content, words, fonts, fonts.scale};
  float margin = kMargin_px * fonts.scale, w = static_cast<float>(width),
        h = static_cast<float>(height);
  ImGui::SetNextWindowPos({margin, margin});
  ImGui::Begin("panel", nullptr, kOverlay);
  panel.All();
  ImGui::End();
  const float top = DrawWarnings(content, words, fonts, w, h, fonts.scale);
  DrawScaleBar(content.mm_per_pixel, fonts, w, h, fonts.scale);
  const float bottom = DrawHint(content.hint, fonts, w, h, fonts.scale);
  if (content.bur_away) {
    DrawBurAway(*content.bur_away, words, fonts, top, w, bottom, fonts.scale);
  }
}

}  // namespace enamel::station::render
