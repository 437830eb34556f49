#include "station/render/screen.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "station/render/gl_objects.h"
#include "station/render/monitors.h"
#include "tests/station/render/virtual_display.h"

namespace enamel::station::render {
namespace {

class ScreenTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    screen_.emplace(
        ScreenOptions{.width_px = kWidth, .height_px = kHeight, .visible = false, .paced = false});
    for (int i = 0; i < 4; ++i) Frame();  // a new window puts its cursor somewhere
  }
  void Frame(std::vector<InputEvent> events = {}) {
    if (!events.empty()) screen_->Inject(std::move(events));
    (void)screen_->Begin();
    screen_->End();
  }
  // Motion of some frames, each with these events.
  double MovedBy(const std::vector<std::vector<InputEvent>>& frames) {
    double moved = 0;
    for (const auto& events : frames) {
      Frame(events);
      moved += screen_->moved_x();
    }
    return moved;
  }

  static constexpr int kWidth = 640, kHeight = 360;
  const VirtualDisplay display_;
  std::optional<Screen> screen_;
};

TEST_F(ScreenTest, WhatAHandMovesIsTheSumOfItsSteps) {
  Frame({InputEvent::Cursor(10, 20)});
  Frame({InputEvent::Cursor(13, 20), InputEvent::Cursor(18, 16)});
  EXPECT_EQ(screen_->moved_x(), 8);
  EXPECT_EQ(screen_->moved_y(), -4);
  Frame();
  EXPECT_EQ(screen_->moved_x(), 0);
  EXPECT_EQ(screen_->cursor_x(), 18);
}

TEST_F(ScreenTest, ThePlaceWhereACursorEntersIsNoMotion) {
  Frame({InputEvent::Cursor(10, 20)});
  Frame({InputEvent::Placed(), InputEvent::Cursor(300, 200), InputEvent::Cursor(302, 200)});
  EXPECT_EQ(screen_->moved_x(), 2);
  EXPECT_EQ(screen_->moved_y(), 0);
  EXPECT_EQ(screen_->cursor_x(), 302) << "buttons are where the cursor is";
}

TEST_F(ScreenTest, WithTheKeyboardGoneEverythingHeldIsLetGoInThatFrame) {
  Frame({InputEvent::Key('W', true), InputEvent::Button(kMouseLeft, true),
         InputEvent::Cursor(10, 20), InputEvent::Key(kKeySpace, true)});
  ASSERT_TRUE(screen_->key(kKeySpace) && screen_->key('W') && screen_->button(kMouseLeft));
  EXPECT_FALSE(screen_->away());
  Frame({InputEvent::Cursor(30, 20), InputEvent::Key('D', true), InputEvent::Focus(false),
         InputEvent::Cursor(90, 20)});
  EXPECT_TRUE(screen_->away());
  for (int key : {int{kKeySpace}, int{'W'}, int{'D'}}) EXPECT_FALSE(screen_->key(key)) << key;
  EXPECT_FALSE(screen_->button(kMouseLeft));
  EXPECT_EQ(screen_->moved_x(), 0);
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(200, 20)}, {InputEvent::Cursor(10, 20)}}), 0);
  // Back: where the cursor is now is no motion, nor what it does in the next two frames.
  EXPECT_EQ(MovedBy({{InputEvent::Focus(true), InputEvent::Cursor(77, 20)},
                     {InputEvent::Cursor(150, 20)},
                     {}}),
            0);
  EXPECT_FALSE(screen_->away());
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(155, 20)}}), 5);
}

// It comes behind an Enter, whose followers wait until their field has the focus.
TEST_F(ScreenTest, TheLossOfTheKeyboardWaitsForNothing) {
  Frame({InputEvent::Button(kMouseLeft, true)});
  Frame({InputEvent::Key(kKeyEnter, true), InputEvent::Character('a')});
  Frame({InputEvent::Focus(false)});
  EXPECT_TRUE(screen_->away());
  EXPECT_FALSE(screen_->button(kMouseLeft));
}

TEST_F(ScreenTest, AKeyboardThatIsLostAndBackWithinAFrameWasAway) {
  Frame({InputEvent::Key(kKeySpace, true)});
  Frame({InputEvent::Focus(false), InputEvent::Focus(true)});
  EXPECT_TRUE(screen_->away());
  EXPECT_FALSE(screen_->key(kKeySpace));
  Frame();
  EXPECT_FALSE(screen_->away());
}

TEST_F(ScreenTest, ACapturedCursorMovesAsFarAsAHandAndNoFartherInAStep) {
  Frame({InputEvent::Cursor(100, 100)});
  screen_->CaptureCursor(true);
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(400, 100)}, {}, {}}), 0) << "by its capture";
  const double step = 0.2 * kHeight;
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(400 + step, 100)}}), step);
  // A remote desktop puts it somewhere and back.
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(20, 100)}, {InputEvent::Cursor(600, 100)}}), 0);
  screen_->CaptureCursor(false);
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(10, 10)}, {InputEvent::Cursor(300, 300)}, {}}), 0);
  EXPECT_EQ(MovedBy({{InputEvent::Cursor(600, 300)}}), 300) << "free, it may be thrown";
}

TEST(MonitorTest, IsFoundByItsNameOrElseByItsNumber) {
  const std::vector<std::string> names = {"eDP-1", "HDMI-1", "2"};
  EXPECT_EQ(FindMonitor(names, "HDMI-1"), 1U);
  EXPECT_EQ(FindMonitor(names, "0"), 0U);
  EXPECT_EQ(FindMonitor(names, "1"), 1U);
  EXPECT_EQ(FindMonitor(names, "2"), 2U) << "its name";
  for (const char* wanted : {"", "HDMI", "3", "-1", "1 ", "+1", "99999999999999999999"}) {
    EXPECT_FALSE(FindMonitor(names, wanted)) << wanted;
  }
  EXPECT_FALSE(FindMonitor({}, "0"));
}

TEST_F(ScreenTest, AMonitorThatIsNotThereIsSaidOnceWithThoseThatAre) {
  std::vector<std::string> said;
  ScreenOptions options{.width_px = kWidth, .height_px = kHeight, .visible = false, .paced = false};
  options.monitor_missing = [&](const std::string& what) { said.push_back(what); };
  for (const char* there : {"", "0", "screen"}) {
    options.monitor = there;
    screen_.reset();
    screen_.emplace(options);
    EXPECT_TRUE(said.empty()) << there;
  }
  for (const bool full : {false, true}) {
    options.monitor = "HDMI-2";
    options.full_screen = full;
    screen_.reset();
    screen_.emplace(options);
    for (int i = 0; i < 3; ++i) Frame();
    ASSERT_EQ(said.size(), 1U);
    EXPECT_NE(said[0].find("expected the monitor 'HDMI-2', found screen"), std::string::npos)
        << said[0];
    EXPECT_EQ(screen_->width(), full ? 1600 : kWidth) << "it is shown all the same";
    said.clear();
  }
}

// Frames of a page with these words, as a person's window draws them.
class RestTest : public ScreenTest {
 protected:
  void SetUp() override {
    ScreenTest::SetUp();
    if (IsSkipped()) return;
    screen_.reset();
    screen_.emplace(ScreenOptions{.width_px = kWidth, .height_px = kHeight, .visible = false});
  }
  uint64_t DrawnIn(int frames, const char* words) {
    const uint64_t before = screen_->drawn();
    for (int i = 0; i < frames; ++i) {
      (void)screen_->Begin();
      ImGui::GetBackgroundDrawList()->AddText({10, 10}, 0xffffffff, words);
      screen_->End();
    }
    return screen_->drawn() - before;
  }
  static constexpr int kSettle = 8;
};

TEST_F(RestTest, APageThatLooksTheSameIsNotDrawnAgain) {
  EXPECT_GT(DrawnIn(kSettle, "due in 3 minutes"), 0U);
  EXPECT_EQ(DrawnIn(5, "due in 3 minutes"), 0U);
  EXPECT_EQ(DrawnIn(5, "due in 2 minutes"), 1U);
  Target picture(kWidth, kHeight, {GL_RGBA8}, false, GL_NEAREST);
  const uint64_t before = screen_->drawn();
  for (int i = 0; i < 3; ++i) {
    (void)screen_->Begin();
    screen_->Show(picture);
    screen_->End();
  }
  EXPECT_EQ(screen_->drawn() - before, 3U) << "what is in a picture is not known";
  EXPECT_EQ(DrawnIn(2, "due in 2 minutes"), 1U) << "the picture is gone";
}

TEST_F(RestTest, APageThatNobodyTouchesRestsAndAnswersTheNextKey) {
  DrawnIn(kSettle, "Ada");
  const auto began = std::chrono::steady_clock::now();
  DrawnIn(4, "Ada");
  // A busy computer takes longer, never less.
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(4 * 90));
  screen_->Inject(InputEvent::Key('A', true));
  (void)screen_->Begin();
  EXPECT_EQ(screen_->events().size(), 1U) << "in the very next frame";
  screen_->End();
}

}  // namespace
}  // namespace enamel::station::render
