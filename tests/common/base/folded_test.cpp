#include "common/base/folded.h"

#include <gtest/gtest.h>

namespace enamel {
namespace {

TEST(FoldedTest, NamesLoseCaseAndAccents) {
  EXPECT_EQ(Folded("Zoë ÑANDÚ-O'Brien 2"), "zoe nandu-o'brien 2");
  EXPECT_EQ(Folded("Zoe\u0308 N\u0303andu\u0301"), "zoe nandu") << "decomposed";
  EXPECT_EQ(Folded("Łukasz Groß, Ærø Ðorđe"), "lukasz gross, aero dorde");
  EXPECT_EQ(Folded("Nguyễn Thị Hương"), "nguyen thi huong");
  EXPECT_EQ(Folded("Şükrü İnan ışık"), "sukru inan isik");
  EXPECT_EQ(Folded("Αλέξανδρος ΆΓΓΕΛΟΣ"), "αλεξανδροσ αγγελοσ");
  EXPECT_EQ(Folded("Юрий ЁЖИКОВ"), "юрии ежиков");
  EXPECT_EQ(Folded("Ｙａｍａｄａ ﬁlip"), "yamada filip");
  EXPECT_EQ(Folded("Ġgant ŽIŽEK"), "ggant zizek");
}

TEST(FoldedTest, OtherTextStays) {
  EXPECT_EQ(Folded("王伟 김철수 प्रिया"), "王伟 김철수 प्रिया");
  EXPECT_EQ(Folded("a\xff\xc3 b"), "a\xff\xc3 b") << "no UTF-8";
  EXPECT_EQ(Folded(""), "");
}

TEST(FoldedTest, WhatIsFoldedStaysWhenItIsFoldedAgain) {
  for (uint32_t code = 0x80; code < 0x10000; ++code) {
    if (code >= 0xd800 && code < 0xe000) continue;
    std::string text;
    text += static_cast<char>(code < 0x800 ? 0xc0 | (code >> 6) : 0xe0 | (code >> 12));
    if (code >= 0x800) text += static_cast<char>(0x80 | ((code >> 6) & 0x3f));
    text += static_cast<char>(0x80 | (code & 0x3f));
    const std::string once = Folded(text);
    ASSERT_EQ(Folded(once), once) << std::hex << code;
  }
}

}  // namespace
}  // namespace enamel
