#include "common/base/utf8.h"

#include <gtest/gtest.h>

namespace enamel {
namespace {

TEST(Utf8Test, CodePointsOfEveryLengthAreRead) {
  std::string_view text = "a\u00e9\u20ac\U0001f9b7";
  EXPECT_EQ(NextCodePoint(text), 0x61u);
  EXPECT_EQ(NextCodePoint(text), 0xe9u);
  EXPECT_EQ(NextCodePoint(text), 0x20acu);
  EXPECT_EQ(NextCodePoint(text), 0x1f9b7u);
  EXPECT_TRUE(text.empty());
}

// RFC 3629, sections 3 and 10: overlong forms, surrogates, beyond U+10FFFF, cut short.
TEST(Utf8Test, WhatIsNotUtf8IsToldAndReplaced) {
  for (std::string_view bad : {"\xe9", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80",
                               "\xf4\x90\x80\x80", "\xe2\x82", "\x80", "\xff"}) {
    EXPECT_FALSE(IsUtf8(bad));
    EXPECT_TRUE(IsUtf8(AsUtf8(bad)));
  }
  EXPECT_EQ(AsUtf8("Jos\xe9 \u00e9"), "Jos\ufffd \u00e9");
  EXPECT_EQ(AsUtf8("caf\xe9"), "caf\ufffd");
}

TEST(Utf8Test, TerminalIsShownControlCharactersAndDoesNotObeyThem) {
  EXPECT_EQ(Printable("a\x1b[31mb\r\n\x7f\u009b2J"), "a\\x1b[31mb\\x0d\\x0a\\x7f\\x9b2J");
  EXPECT_EQ(Printable("a\u200bb\U000e0041"), "a\\u200bb\\U000e0041");
  EXPECT_EQ(Printable("a\u202eb\u2066\u2028\ufeff"), "a\\u202eb\\u2066\\u2028\\ufeff");
  EXPECT_EQ(Printable("Zo\u00eb \xff"), "Zo\u00eb \ufffd");
}

}  // namespace
}  // namespace enamel
