#include "station/render/panel.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>

namespace enamel::station::render {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontSize_px = 17;
constexpr float kMargin_px = 16, kPanelWidth_px = 250;
constexpr ImGuiWindowFlags kOverlay =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

constexpr std::array<const char*, 6> kWarningTexts = {
    "Force limited: press less",
    "Ticks run late",
    "Fault: force is off until the operator resets it",
    "Part of the recording is missing",
    "Server not reachable: recording continues here",
    "Pulp exposed"};

ImVec4 ForceColour(double share) {
  if (share < 0.6) return {0.22f, 0.74f, 0.62f, 1};
  return share < 0.9 ? ImVec4{0.93f, 0.68f, 0.24f, 1} : ImVec4{0.90f, 0.32f, 0.28f, 1};
}

void DrawTime(const PanelContent& c) {
  std::string text = TimerText(c.state.time_s);
  if (c.time_limit_s > 0) text += " of " + TimerText(c.time_limit_s);
  bool over = c.time_limit_s > 0 && c.state.time_s > c.time_limit_s;
  ImGui::SetWindowFontScale(1.6f);
  ImGui::TextColored(over ? ImVec4{0.95f, 0.45f, 0.4f, 1} : ImVec4{1, 1, 1, 1}, "%s", text.c_str());
  ImGui::SetWindowFontScale(1);
  ImGui::TextDisabled("%s", c.state.bur_on ? "bur turning" : "bur still");
}

void DrawForce(const PanelContent& c) {
  double force = glm::length(c.state.force_sent_n),
         share = force / std::max(c.force_full_scale_n, 1e-3);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f N", force);
  ImGui::Text("Force");
  ImGui::SameLine(kPanelWidth_px - ImGui::CalcTextSize(text).x);
  ImGui::TextUnformatted(text);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ForceColour(share));
  ImGui::ProgressBar(static_cast<float>(std::clamp(share, 0.0, 1.0)),
                     {kPanelWidth_px - kMargin_px, 10}, "");
  ImGui::PopStyleColor();
}

void DrawRemoved(const PanelContent& c) {
  ImGui::Text("Removed");
  bool any = false;
  for (size_t t = 1; t < c.state.removed_mm3.size(); ++t) {
    double mm3 = c.state.removed_mm3[t];
    if (mm3 < 0.005) continue;
    any = true;
    char text[32];
    std::snprintf(text, sizeof text, "%.2f mm\xc2\xb3", mm3);
    std::string name(cutting::TissueName(static_cast<cutting::Tissue>(t)));
    ImGui::TextDisabled("  %s", name.c_str());
    ImGui::SameLine(kPanelWidth_px - ImGui::CalcTextSize(text).x);
    ImGui::TextUnformatted(text);
  }
  if (!any) ImGui::TextDisabled("  nothing yet");
}

void DrawWarnings(const PanelContent& c, const ImVec2& size) {
  std::string text = WarningText(c.state.warnings);
  if (text.empty()) return;
  ImGui::SetNextWindowPos({size.x / 2, kMargin_px}, ImGuiCond_Always, {0.5f, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4{0.55f, 0.13f, 0.10f, 0.92f});
  ImGui::Begin("warnings", nullptr, kOverlay);
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
  ImGui::PopStyleColor();
}

void DrawScaleBar(const PanelContent& c, const ImVec2& size) {
  if (c.mm_per_pixel <= 0) return;
  auto length = static_cast<float>(1 / c.mm_per_pixel);
  ImVec2 right{size.x - kMargin_px, size.y - kMargin_px}, left{right.x - length, right.y};
  ImDrawList* list = ImGui::GetForegroundDrawList();
  ImU32 white = IM_COL32(255, 255, 255, 200);
  list->AddLine(left, right, white, 2);
  list->AddLine({left.x, left.y - 5}, {left.x, left.y + 5}, white, 2);
  list->AddLine({right.x, right.y - 5}, {right.x, right.y + 5}, white, 2);
  ImVec2 text = ImGui::CalcTextSize("1 mm");
  list->AddText({(left.x + right.x - text.x) / 2, left.y - 6 - text.y}, white, "1 mm");
}

}  // namespace

std::string TimerText(double seconds) {
  auto s = static_cast<long>(std::max(seconds, 0.0));
  char text[48];
  if (s >= 3600)
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  else
    std::snprintf(text, sizeof text, "%ld:%02ld", s / 60, s % 60);
  return text;
}

std::string WarningText(uint32_t warnings) {
  std::string out;
  for (size_t i = 0; i < kWarningTexts.size(); ++i) {
    if (!(warnings >> i & 1)) continue;
    if (!out.empty()) out += '\n';
    out += kWarningTexts[i];
  }
  return out;
}

Panel::Panel(GLFWwindow* window) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  std::error_code none;
  if (std::filesystem::exists(kFont, none)) io.Fonts->AddFontFromFileTTF(kFont, kFontSize_px);
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = style.FrameRounding = 6;
  style.WindowPadding = {kMargin_px, 12};
  style.WindowBorderSize = 0;
  style.Colors[ImGuiCol_WindowBg] = {0.06f, 0.065f, 0.075f, 0.78f};
  style.Colors[ImGuiCol_TextDisabled] = {0.68f, 0.71f, 0.75f, 1};
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Panel::~Panel() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Panel::Draw(const PanelContent& content) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({kMargin_px, kMargin_px});
  ImGui::SetNextWindowSizeConstraints({kPanelWidth_px + kMargin_px, 0},
                                      {kPanelWidth_px + kMargin_px, size.y});
  ImGui::Begin("panel", nullptr, kOverlay);
  if (!content.heading.empty()) {
    ImGui::PushTextWrapPos(kPanelWidth_px);
    ImGui::TextUnformatted(content.heading.c_str());
    ImGui::PopTextWrapPos();
    ImGui::Separator();
  }
  if (content.has_state) {
    DrawTime(content);
    ImGui::Spacing();
    DrawForce(content);
    ImGui::Spacing();
    DrawRemoved(content);
  } else {
    ImGui::TextDisabled("waiting for the first tick");
  }
  ImGui::End();
  DrawWarnings(content, size);
  DrawScaleBar(content, size);
  ImGui::GetForegroundDrawList()->AddText(
      {kMargin_px, size.y - kMargin_px - ImGui::GetFontSize()}, IM_COL32(190, 196, 205, 220),
      "1 occlusal   2 buccal   3 mesial   4 oblique   drag: turn   right drag: move   wheel: zoom");
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace enamel::station::render
