#include "station/render/panel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "station/render/lines.h"
#include "station/render/shaped_text.h"

namespace enamel::station::render {
namespace {

constexpr float kMargin_px = 28, kPanelWidth_px = 505, kChoiceWidth_px = 420,
                kBar_px = 20;            // at the reference height
constexpr float kWarningsHeight = 0.3f;  // of the picture, at most in the large letters
// Shares of the picture, at most: the tooth needs the rest.
constexpr float kPanelShare = 0.36f, kHintShare = 0.17f, kChoiceShare = 0.3f;
constexpr double kShown_mm3 = 0.005;  // less would be shown as 0.00
constexpr ImGuiWindowFlags kOverlay =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

ImVec4 ColourFor(Bearing bearing) {
  auto [r, g, b] = ColourOf(bearing);
  return {r, g, b, 1};
}

// In the order of their bits.
constexpr std::array<const char*, kWarningCount> kWarnings = {
    "warning.press_less", "warning.uneven",  "warning.force_off",   "warning.held_up",
    "warning.offline",    "warning.pulp",    "warning.disk",        "warning.silent",
    "warning.time",       "warning.resumed", "warning.no_realtime", "warning.swing"};
const ImVec4 kAlarm{0.60f, 0.13f, 0.10f, 0.94f}, kCalm{0.16f, 0.30f, 0.42f, 0.94f};

// The panel is as wide as its letters need, where the picture has room for that.
float PanelWidth(const Fonts& fonts, int width) {
  const float by_picture = kPanelWidth_px * fonts.scale;
  return std::clamp(kPanelWidth_px * fonts.letters, by_picture,
                    std::max(by_picture, kPanelShare * static_cast<float>(width)));
}

struct Panel {
  const PanelContent& c;
  const Words& words;
  const Fonts& fonts;
  float px;  // one pixel of the reference picture
  float width;

  bool InOneLine(const std::string& name, const std::string& value) const {
    return ImGui::CalcTextSize(name.c_str()).x + ImGui::GetStyle().ItemSpacing.x +
               ImGui::CalcTextSize(value.c_str()).x <=
           width;
  }
  // The value at the right, below the name where both have no room in one line.
  void Value(const std::string& name, const std::string& value) const {
    const float left = ImGui::GetCursorPosX();
    const bool one = InOneLine(name, value);
    ImGui::TextUnformatted(name.c_str());
    if (one) ImGui::SameLine();
    std::istringstream lines(InLines(value, width, *ImGui::GetFont()));
    for (std::string line; std::getline(lines, line);) {
      ImGui::SetCursorPosX(left + width - ImGui::CalcTextSize(line.c_str()).x);
      ImGui::TextUnformatted(line.c_str());
    }
  }
  // Height of what Value will draw in the current font.
  float HeightOfValue(const std::string& name, const std::string& value) const {
    if (value.empty() || InOneLine(name, value)) return ImGui::GetTextLineHeightWithSpacing();
    const std::string lines = InLines(value, width, *ImGui::GetFont());
    return static_cast<float>(2 + std::ranges::count(lines, '\n')) *
           ImGui::GetTextLineHeightWithSpacing();
  }
  float HeightOfBar(const char* name, const std::string& value) const {
    ImGui::PushFont(fonts.far);
    const float text = HeightOfValue(words.Say(name), value);
    ImGui::PopFont();
    return text + kBar_px * px + ImGui::GetStyle().ItemSpacing.y;
  }

  // `mark`: where the bar becomes critical; 0: nowhere.
  void Bar(const char* name, const std::string& value, double share, Bearing bearing,
           double mark = 0) const {
    ImGui::PushFont(fonts.far);
    Value(words.Say(name), value);
    ImGui::PopFont();
    ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ColourFor(bearing));
    ImGui::ProgressBar(static_cast<float>(std::clamp(share, 0.0, 1.0)), {width, kBar_px * px}, "");
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
    double force = glm::length(c.state.pressed_n);
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
  const char* LeewayName() const {
    return c.reach.leeway->left_mm < 0 ? "panel.over" : "panel.limit";
  }
  std::string LeewayLeft() const {
    return words.Decimal(std::fabs(c.reach.leeway->left_mm), 2) + " mm";
  }
  std::string LeewayWhere() const {
    const std::string_view where = c.reach.leeway->where;
    return words.Say(where.empty() ? "panel.until_limit" : where);
  }
  std::string LeewayUsed() const {
    if (!c.zones) return "";
    if (c.zones->neighbour_mm3 >= kShown_mm3) {
      return words.Say("panel.neighbour_cut",
                       {{"volume", words.Decimal(c.zones->neighbour_mm3, 2)}});
    }
    if (c.zones->beyond_mm3 >= kShown_mm3) {
      return words.Say("panel.too_much", {{"volume", words.Decimal(c.zones->beyond_mm3, 2)}});
    }
    return words.Say("panel.leeway_used", {{"percent", words.Decimal(c.zones->leeway_percent, 0)}});
  }
  void Leeway() const {
    if (!c.reach.leeway) return;
    const Reach::Leeway& leeway = *c.reach.leeway;
    const bool beyond = leeway.left_mm < 0 || leeway.whole_mm <= 0;
    Bar(LeewayName(), LeewayLeft(), beyond ? 1 : leeway.left_mm / leeway.whole_mm,
        BearingOf(leeway));
    Value(LeewayWhere(), LeewayUsed());
  }

  void Pulp() const {
    if (!c.reach.pulp_mm) return;
    double left = *c.reach.pulp_mm;
    const std::string shown =
        left >= kPulpFar_mm ? "> " + words.Decimal(left, 0) : words.Decimal(left, 2);
    Bar("panel.pulp", shown + " mm", left / kPulpFar_mm, BearingOfPulp(left),
        kPulpThin_mm / kPulpFar_mm);
  }

  // Name and volume of each tissue of which something is removed, or of all of them together.
  std::vector<std::pair<std::string, std::string>> Removed(bool together) const {
    if (!c.recorded) return {{words.Say("panel.not_recorded"), ""}};
    std::vector<std::pair<std::string, std::string>> out;
    double all_mm3 = 0;
    for (size_t t = 1; t < c.state.removed_mm3.size(); ++t) {
      const double mm3 = c.state.removed_mm3[t];
      all_mm3 += mm3;
      if (mm3 < kShown_mm3 || together) continue;
      const auto tissue = static_cast<cutting::Tissue>(t);
      out.push_back({words.Say("tissue." + std::string(cutting::TissueName(tissue))),
                     words.Decimal(mm3, 2) + " mm³"});
    }
    const bool any = all_mm3 >= kShown_mm3;
    if (!any) out.push_back({words.Say("panel.removed"), words.Say("panel.nothing_yet")});
    if (any && together) {
      out.push_back({words.Say("panel.removed"), words.Decimal(all_mm3, 2) + " mm³"});
    }
    return out;
  }

  // Without heading and volumes.
  float HeightOfBars() const {
    const float line = ImGui::GetTextLineHeightWithSpacing(), gap = ImGui::GetStyle().ItemSpacing.y;
    float height = fonts.far->FontSize + 3 * gap + HeightOfBar("panel.force", "0.00 N");
    if (c.time_limit_s > 0) height += line;
    if (c.zones) height += HeightOfBar("panel.target", "100 %");
    if (c.reach.leeway) {
      height +=
          HeightOfBar(LeewayName(), LeewayLeft()) + HeightOfValue(LeewayWhere(), LeewayUsed());
    }
    if (c.reach.pulp_mm) height += HeightOfBar("panel.pulp", "> 2.00 mm");
    return height;
  }

  // `room`: in height.
  void All(float room) const {
    ImGui::PushFont(fonts.near);
    const float line = ImGui::GetTextLineHeightWithSpacing(),
                heading_height =
                    SizeOf(fonts, *fonts.near, c.heading, width).y + line - ImGui::GetFontSize();
    room -= c.has_state ? HeightOfBars() : line;
    auto removed = Removed(false);
    const auto height_of = [&](const auto& values) {
      float height = 0;
      for (const auto& [name, value] : values) height += HeightOfValue(name, value);
      return height;
    };
    if (heading_height + height_of(removed) > room) removed = Removed(true);
    const bool titled = !c.heading.empty() && heading_height + height_of(removed) <= room;
    if (titled) {
      ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
      Write(fonts, c.heading, width);
      ImGui::PopStyleColor();
    }
    if (!c.has_state) {
      ImGui::TextDisabled("%s", words.Say("panel.waiting").c_str());
    } else {
      Time();
      ImGui::Spacing();
      Force();
      Zones();
      Leeway();
      Pulp();
      ImGui::Spacing();
      if (height_of(removed) <= room) {
        for (const auto& [name, value] : removed) Value(name, value);
      }
    }
    ImGui::PopFont();
  }
};

ImVec2 SizeOf(const ImFont& font, const std::string& lines) {
  return font.CalcTextSizeA(font.FontSize, FLT_MAX, 0, lines.c_str());
}

// Ends at the height that is returned.
float DrawWarnings(const PanelContent& content, const Words& words, const Fonts& fonts,
                   const Canvas& canvas) {
  const std::string text = WarningText(words, content);
  if (text.empty()) return 0;
  const float px = fonts.scale, height = static_cast<float>(canvas.height);
  const Span free = BesidePanel(fonts, canvas);
  const float widest = free.to - free.from - 3 * kMargin_px * px;
  auto lines_of = [&](const ImFont& font) { return InEvenLines(text, widest, font); };
  // Several at a time in smaller letters: the tooth is below them.
  const ImVec2 large = SizeOf(*fonts.far, lines_of(*fonts.far));
  ImFont* font = large.y > kWarningsHeight * height ? fonts.text : fonts.far;
  const std::string lines = lines_of(*font);
  ImGui::PushFont(font);
  ImGui::SetNextWindowPos({free.middle(), kMargin_px * px}, ImGuiCond_Always, {0.5f, 0});
  const ImVec2 size = SizeOf(*font, lines);
  FitNextWindow(size.x, size.y);
  // These are no cause for alarm: nothing is lost, and cutting continues.
  constexpr uint32_t kNoAlarm = kWarnResumed | kWarnOffline;
  const bool calm = content.fault.empty() && (content.state.warnings & ~kNoAlarm) == 0;
  ImGui::PushStyleColor(ImGuiCol_WindowBg, calm ? kCalm : kAlarm);
  ImGui::Begin("warnings", nullptr, kOverlay);
  ImGui::TextUnformatted(lines.c_str());
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
void DrawBurAway(const PanelContent& content, const Words& words, const Fonts& fonts, float top,
                 const Canvas& canvas) {
  const glm::vec2& away = *content.bur_away;
  const float px = fonts.scale, bottom = canvas.floor, inset = 70 * px, size = 34 * px;
  Span free = BesidePanel(fonts, canvas);
  if (content.several_burs) {
    const float burs = ChoiceWidth(fonts, canvas);
    canvas.left_handed ? free.from += burs : free.to -= burs;
  }
  const glm::vec2 middle(free.middle(), 0.5f * (top + bottom));
  const float to_side = (0.5f * (free.to - free.from) - inset) / std::max(std::fabs(away.x), 1e-3f),
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
float DrawHint(std::string spaced, const Fonts& fonts, float width, float height, float px) {
  const float size = fonts.near->FontSize, widest = width - 2 * kMargin_px * px;
  std::string hint;
  ImVec2 text;
  for (; !spaced.empty(); spaced = WithoutLastKey(spaced)) {
    hint = InEvenLines(Unbroken(spaced), widest, *fonts.near);
    text = SizeOf(*fonts.near, hint);
    if (text.y <= kHintShare * height) break;
  }
  if (spaced.empty()) return height;
  const ImVec2 at{kMargin_px * px, height - kMargin_px * px - text.y};
  ImDrawList* list = ImGui::GetForegroundDrawList();
  list->AddRectFilled({at.x - 12 * px, at.y - 6 * px},
                      {at.x + text.x + 12 * px, at.y + text.y + 6 * px}, IM_COL32(15, 17, 20, 200),
                      8 * px);
  list->AddText(fonts.near, size, at, IM_COL32(214, 220, 228, 255), hint.c_str());
  return at.y - 6 * px;
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

std::string WithoutLastKey(const std::string& hint) {
  const size_t last = hint.rfind("   ");
  return last == hint.npos ? "" : hint.substr(0, last);
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

Span BesidePanel(const Fonts& fonts, const Canvas& canvas) {
  const auto width = static_cast<float>(canvas.width);
  const float panel = PanelWidth(fonts, canvas.width) + 4 * kMargin_px * fonts.scale;
  return canvas.left_handed ? Span{0, width - panel} : Span{panel, width};
}

float ChoiceWidth(const Fonts& fonts, const Canvas& canvas) {
  const float by_picture = kChoiceWidth_px * fonts.scale;
  return std::clamp(kChoiceWidth_px * fonts.letters, by_picture,
                    std::max(by_picture, kChoiceShare * static_cast<float>(canvas.width)));
}

Canvas DrawPanel(const PanelContent& content, const Words& words, const Fonts& fonts,
                 Canvas canvas) {
  const Panel panel{content, words, fonts, fonts.scale, PanelWidth(fonts, canvas.width)};
  const float margin = kMargin_px * fonts.scale, w = static_cast<float>(canvas.width),
              h = static_cast<float>(canvas.height);
  canvas.floor = DrawHint(content.hint, fonts, w, h, fonts.scale);
  ImGui::SetNextWindowPos({canvas.left_handed ? w - margin : margin, margin}, ImGuiCond_Always,
                          {canvas.left_handed ? 1.0f : 0.0f, 0});
  ImGui::Begin("panel", nullptr, kOverlay);
  panel.All(canvas.floor - margin - 2 * ImGui::GetStyle().WindowPadding.y);
  ImGui::End();
  const float top = DrawWarnings(content, words, fonts, canvas);
  DrawScaleBar(content.mm_per_pixel, fonts, w, h, fonts.scale);
  if (content.bur_away) DrawBurAway(content, words, fonts, top, canvas);
  return canvas;
}

}  // namespace enamel::station::render
