#include "station/render/keyboard.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "station/render/screen.h"
#include "tests/station/render/second_client.h"
#include "tests/station/render/virtual_display.h"

namespace enamel::station::render {
namespace {

using Layout = std::map<int, const char*>;  // what is printed at a place of a US keyboard

Keyboard With(const Layout& layout) {
  return Keyboard([layout](int place) {
    const auto found = layout.find(place);
    return found == layout.end() ? nullptr : found->second;
  });
}

const Layout kFrench = {{'Q', "a"}, {'W', "z"}, {'A', "q"}, {'Z', "w"}, {'M', ","},
                        {';', "m"}, {'S', "s"}, {'D', "d"}, {'1', "&"}, {'2', "é"}};
const Layout kGerman = {{'Y', "z"}, {'Z', "y"}, {';', "ö"}, {'M', "m"}};
const Layout kRussian = {{'M', "ь"}, {'W', "ц"}};

TEST(KeyboardTest, ALetterIsTheKeyItIsPrintedOn) {
  Keyboard french = With(kFrench), german = With(kGerman);
  EXPECT_EQ(french.Event(';', true, 0, false).code, 'M');
  EXPECT_EQ(french.Event('M', true, 0, false).code, ',');
  EXPECT_EQ(german.Event('Y', true, 0, false).code, 'Z');
  EXPECT_EQ(french.Event(';', true, 0, true).place, ';') << "and its place is kept";
}

TEST(KeyboardTest, WhatLiesUnderAHandIsNamedByWhatIsPrintedThere) {
  const Keyboard french = With(kFrench);
  EXPECT_EQ(french.At('W'), 'Z');
  EXPECT_EQ(french.At('A'), 'Q');
  EXPECT_EQ(french.At('S'), 'S');
}

TEST(KeyboardTest, DigitsSignsOfOtherScriptsAndKeysThatWriteNothingKeepTheirPlace) {
  const Keyboard french = With(kFrench), german = With(kGerman), russian = With(kRussian);
  EXPECT_EQ(french.At('1'), '1');
  EXPECT_EQ(french.At('2'), '2');
  EXPECT_EQ(german.At(';'), ';') << "no ASCII letter";
  EXPECT_EQ(russian.At('M'), 'M');
  EXPECT_EQ(french.At(kKeySpace), kKeySpace);
  EXPECT_EQ(french.At(kKeyF1), kKeyF1);
  EXPECT_EQ(french.At(-1), -1) << "a key that GLFW does not know";
}

TEST(KeyboardTest, AReleaseIsOfTheKeyThatWasPressedThoughTheLayoutChanged) {
  Layout layout = kFrench;
  Keyboard keyboard([&layout](int place) {
    const auto found = layout.find(place);
    return found == layout.end() ? nullptr : found->second;
  });
  EXPECT_EQ(keyboard.Event('W', true, 0, false).code, 'Z');
  layout.clear();
  EXPECT_EQ(keyboard.Event('W', false, 0, false).code, 'Z');
  EXPECT_EQ(keyboard.Event('W', true, 0, false).code, 'W');
}

// Another program presses two keys while the X server's layout is French. Keycodes 47 and 25 are the
// places of ; and W (xkeyboard-config, evdev).
TEST(KeyboardTest, OnAFrenchKeyboardMIsM) {
  const VirtualDisplay display;
  if (!display.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
  if (std::system("setxkbmap fr >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "skipped: setxkbmap or its French layout is not installed";
  Screen screen({.width_px = 320, .height_px = 200, .visible = true, .paced = false});
  SecondClient other;
  EXPECT_EQ(screen.KeyAt('W'), 'Z');
  EXPECT_EQ(screen.KeyAt('A'), 'Q');
  ASSERT_TRUE(other.TapKey("Enamel", 47));
  ASSERT_TRUE(other.TapKey("Enamel", 25));
  std::string pressed;
  for (int i = 0; i < 10; ++i) {
    (void)screen.Begin();
    for (const InputEvent& event : screen.events()) {
      if (event.kind == InputEvent::Kind::kKey && event.pressed)
        pressed += static_cast<char>(event.code);
    }
    screen.End();
  }
  EXPECT_EQ(pressed, "MZ");
}

}  // namespace
}  // namespace enamel::station::render
