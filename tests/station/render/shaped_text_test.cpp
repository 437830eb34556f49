#include "station/render/shaped_text.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "station/render/screen.h"
#include "tests/station/render/virtual_display.h"

// What a text has to look like follows from its script, not from the library that shapes it.
namespace enamel::station::render {
namespace {

namespace fs = std::filesystem;

constexpr float kCapital_px = 20;
// Debian's package fonts-noto-core; the other scripts are in DejaVu.
bool HasNoto(const char* script) {
  return fs::exists(std::string("/usr/share/fonts/truetype/noto/NotoSans") + script +
                    "-Regular.ttf");
}

class ShapedTextTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    if (!FindFont()) GTEST_SKIP() << "skipped: no DejaVu";
    screen_.emplace(ScreenOptions{.width_px = 800, .height_px = 600, .visible = false});
  }

  ShapedTexts& shaped() { return *screen_->fonts().shaped; }
  const ShapedTexts::Block& Of(const std::string& text, float wrap = 0) {
    return shaped().Of(text, kCapital_px, false, wrap);
  }
  // Middle of what the letters cover in a picture's upper quarter, as a share of its width.
  double MiddleOfTheTallest(const ShapedTexts::Block& block) {
    const auto w = static_cast<size_t>(block.ink_w), h = static_cast<size_t>(block.ink_h);
    std::vector<unsigned char> pixels(w * h);
    glBindTexture(GL_TEXTURE_2D, block.texture);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_UNSIGNED_BYTE, pixels.data());
    double all = 0, at = 0;
    for (size_t y = 0; y < h / 4; ++y)
      for (size_t x = 0; x < w; ++x) {
        all += pixels[y * w + x];
        at += pixels[y * w + x] * (static_cast<double>(x) + 0.5);
      }
    return at / all / static_cast<double>(w);
  }

  VirtualDisplay display_;
  std::optional<Screen> screen_;
};

TEST_F(ShapedTextTest, NamesOfEveryScriptHaveAllTheirLetters) {
  const std::pair<const char*, std::string> names[] = {
      {"", "Наталья Щербакова"}, {"", "Ελένη Παπαδοπούλου"}, {"", "Nguyễn Thị Ngọc Ánh"},
      {"", "محمد الأمين"},       {"", "זהבה כהן"},           {"", "Անի Հակոբյան"},
      {"", "ნინო ბერიძე"},       {"Thai", "สมชาย ใจดี"},      {"Devanagari", "अनुष्का शर्मा"},
      {"Bengali", "রবীন্দ্রনাথ"},  {"Tamil", "கார்த்திக்"},       {"Ethiopic", "አበበ ቢቂላ"},
      {"Khmer", "សុខា"}};
  for (const auto& [noto, name] : names) {
    if (*noto != '\0' && !HasNoto(noto)) {
      std::printf("skipped: %s, without fonts-noto-core\n", name.c_str());
      continue;
    }
    EXPECT_EQ(Of(name).missing, 0) << name;
    EXPECT_GT(Of(name).width, 2 * kCapital_px) << name;
  }
  EXPECT_GT(Of("\U0010FFFD").missing, 0) << "a letter that nobody has drawn";
}

TEST_F(ShapedTextTest, NamesOfOtherSchoolsHaveAllTheirLetters) {
  const fs::path file = fs::path(ENAMEL_SHARED_DATA) / "borders/rosters/names_for_the_chair.csv";
  std::ifstream in(file);
  if (!in || !HasNoto("Thai")) GTEST_SKIP() << "skipped: no shared data or no fonts-noto-core";
  std::string line;
  std::getline(in, line);  // the columns' names
  int names = 0;
  while (std::getline(in, line)) {
    const size_t from = line.find(',') + 1;
    const std::string name = line.substr(from, line.find(',', from) - from);
    EXPECT_EQ(Of(name).missing, 0) << name;
    ++names;
  }
  EXPECT_GE(names, 6);
}

// A zero-width non-joiner between letters keeps each in its form at a word's end, which is wider.
TEST_F(ShapedTextTest, ArabicLettersJoin) {
  EXPECT_LT(Of("محمد").width, Of("م\u200cح\u200cم\u200cد").width);
}

// The tall letter, alef, is the first of the one and the last of the other.
TEST_F(ShapedTextTest, ArabicRunsFromRightToLeft) {
  EXPECT_GT(MiddleOfTheTallest(Of("اس")), 0.7);
  EXPECT_LT(MiddleOfTheTallest(Of("سا")), 0.3);
}

TEST_F(ShapedTextTest, MarksStandAboveTheirLetter) {
  if (!HasNoto("Thai")) GTEST_SKIP() << "skipped: no fonts-noto-core";
  EXPECT_EQ(Of("ก่").width, Of("ก").width);
  EXPECT_GT(Of("ก่").ink_h, Of("ก").ink_h);
}

TEST_F(ShapedTextTest, LongTextsKeepToTheirWidthAndBeginAtItsLeft) {
  std::string remark;
  for (int i = 0; i < 12; ++i) remark += "توقف هنا ";
  const float line = Of("توقف هنا").height;
  const ShapedTexts::Block& block = Of(remark, 200);
  EXPECT_LE(block.width, 200);
  EXPECT_GE(block.height, 2.9f * line);
  EXPECT_LT(std::abs(block.ink_x), kCapital_px);
  EXPECT_LT(Of("توقف هنا", 700).width, 300) << "one line is no wider than its words";
  EXPECT_LT(std::abs(Of("توقف هنا", 700).ink_x), kCapital_px);
}

TEST_F(ShapedTextTest, OurOwnTextsAreNotShaped) {
  (void)screen_->Begin();
  const Fonts& fonts = screen_->fonts();
  for (const char* text : {"Łukasz Żółć, Ångström: ≥ 5 µm", "one\ntwo", "\xff\xfe"}) {
    EXPECT_TRUE(HasLetters(*fonts.text, text)) << text;
    EXPECT_GT(SizeOf(fonts, *fonts.text, text).x, 0);
    Draw(fonts, *ImGui::GetForegroundDrawList(), *fonts.text, {0, 0}, 0xffffffff, text);
  }
  EXPECT_EQ(shaped().made(), 0U);
  EXPECT_FALSE(HasLetters(*fonts.text, "Ada สมชาย"));
  screen_->End();
}

TEST_F(ShapedTextTest, WhatIsNotShownAnyMoreIsForgotten) {
  const auto frame = [&](int from, int to) {
    (void)screen_->Begin();
    for (int i = from; i < to; ++i) Of("я" + std::to_string(i));
    screen_->End();
  };
  frame(0, 300);
  EXPECT_EQ(shaped().made(), 300U);
  frame(200, 300);
  frame(200, 300);
  frame(0, 1);
  EXPECT_EQ(shaped().made(), 301U) << "the first was forgotten";
  frame(299, 300);
  EXPECT_EQ(shaped().made(), 301U) << "what is shown is kept";
}

}  // namespace
}  // namespace enamel::station::render
