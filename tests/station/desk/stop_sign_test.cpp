#include "station/desk/stop_sign.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace enamel::station::desk {
namespace {

TEST(StopSignTest, EachFaultHasASignAndAFaultComesFirst) {
  EXPECT_EQ(StopOf(Fault::kUnplugged, false, false), Stop::kUnplugged);
  EXPECT_EQ(StopOf(Fault::kStalled, true, true), Stop::kUnplugged);
  EXPECT_EQ(StopOf(Fault::kTooSlow, false, false), Stop::kUnplugged);
  EXPECT_EQ(StopOf(Fault::kSwitchedOff, false, false), Stop::kPower);
  for (Fault late : {Fault::kLateOnce, Fault::kLateOften}) {
    EXPECT_EQ(StopOf(late, false, true), Stop::kBusy);
  }
  EXPECT_EQ(StopOf(Fault::kNone, true, true), Stop::kDisk);
  EXPECT_EQ(StopOf(Fault::kNone, true, false), Stop::kHolder);
  EXPECT_EQ(StopOf(Fault::kNone, false, false), Stop::kNone);
}

// White places of the disk's sign whose mirror image is not drawn.
int OneSided(const Rect& at) {
  constexpr ImU32 kWhite = IM_COL32(245, 246, 248, 0);
  DrawStopSign(Stop::kDisk, at);
  std::vector<ImVec2> white;
  for (const ImDrawVert& v : ImGui::GetWindowDrawList()->VtxBuffer) {
    if ((v.col & ~IM_COL32_A_MASK) == kWhite) white.push_back(v.pos);
  }
  EXPECT_GT(white.size(), 60U);
  return static_cast<int>(std::ranges::count_if(white, [&](const ImVec2& a) {
    return std::ranges::none_of(white, [&](const ImVec2& b) {
      return std::fabs(a.x + b.x - at.x0 - at.x1) < 0.3f && std::fabs(a.y - b.y) < 0.3f;
    });
  }));
}

// Where two of its places were within a rounding error of each other, a spike stood out.
TEST(StopSignTest, TheDiskIsTheSameOnBothSides) {
  ImGuiContext* context = ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // else it leaves a file where the test was started
  ImGui::GetIO().DisplaySize = {1920, 1080};
  ImGui::GetIO().Fonts->Build();
  for (int i = 0; i < 200; ++i) {
    const float x = 221 + 1.37f * static_cast<float>(i), y = 187 + 0.61f * static_cast<float>(i);
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({1920, 1080});
    ImGui::Begin("page", nullptr, ImGuiWindowFlags_NoDecoration);
    EXPECT_EQ(OneSided({x, y, x + 106, y + 106}), 0) << x << ", " << y;
    ImGui::End();
    ImGui::Render();
  }
  ImGui::DestroyContext(context);
}

}  // namespace
}  // namespace enamel::station::desk
