#include "station/render/lines.h"

#include <gtest/gtest.h>

namespace enamel::station::render {
namespace {

// Each letter is one wide, a Chinese one two.
float Advance(uint32_t code) { return code < 0x2E80 ? 1.0F : 2.0F; }
std::string In(float width, std::string_view text) { return InLines(text, width, Advance); }

TEST(LinesTest, EndAtSpaces) {
  EXPECT_EQ(In(11, "Cut further there."), "Cut further\nthere.");
  EXPECT_EQ(In(10, "Cut further there."), "Cut\nfurther\nthere.");
  EXPECT_EQ(In(100, "Cut further there."), "Cut further there.");
  EXPECT_EQ(In(4, "one\ntwo three"), "one\ntwo\nthree");
}

// Dear ImGui breaks after a full stop: "82." and "0 %" were in two lines.
TEST(LinesTest, KeepAFigureAndItsUnitTogether) {
  EXPECT_EQ(In(16, "full marks from 82.0 %, none"), "full marks from\n82.0 %, none");
  EXPECT_EQ(In(20, "full marks from 82,0 %, none"), "full marks from\n82,0 %, none");
}

TEST(LinesTest, OfChineseEndBetweenLettersAndNotBeforeAMark) {
  EXPECT_EQ(In(8, "请换一台设备"), "请换一台\n设备");
  EXPECT_EQ(In(8, "请换一台。设"), "请换一\n台。设");
  EXPECT_EQ(In(8, "深（一二三）"), "深（一\n二三）");
  EXPECT_EQ(In(8, "请换一台。\n设"), "请换\n一台。\n设");
}

TEST(LinesTest, OfAWarningAreAboutAsLong) {
  const auto even = [](float width, std::string_view text) {
    return InEvenLines(text, width, Advance);
  };
  EXPECT_EQ(even(31, "No server: recording continues here"),
            "No server: recording\ncontinues here");
  EXPECT_EQ(even(100, "No server"), "No server");
  EXPECT_EQ(even(20, "力已关闭。请接上，松开踏板"), "力已关闭。请接\n上，松开踏板");
  EXPECT_EQ(even(14, "M: mirror   N: bur"), "M: mirror\nN: bur") << "with spaces at its end";
}

TEST(LinesTest, WithoutAPlaceToBreakStayLong) {
  EXPECT_EQ(In(5, "/var/lib/enamel/spool"), "/var/lib/enamel/spool");
  EXPECT_EQ(In(5, ""), "");
}

}  // namespace
}  // namespace enamel::station::render
