#include "common/protocol/remark.h"

#include <gtest/gtest.h>

namespace enamel::protocol {
namespace {

std::string Times(const std::string& text, size_t n) {
  std::string out;
  for (size_t i = 0; i < n; ++i) out += text;
  return out;
}

TEST(RemarkTest, LineInAnyScriptPassesAsItIs) {
  for (const char* text : {"Stop.", "请停一下：近中壁太薄。", "Прекратите", "a \xf0\x9f\x98\x80"}) {
    auto checked = CheckedRemark(text);
    ASSERT_TRUE(checked.ok()) << checked.status().message();
    EXPECT_EQ(*checked, text);
  }
  EXPECT_EQ(*CheckedRemark(" two\nlines\t"), "two lines");
}

TEST(RemarkTest, LengthCountsCharactersAndNotBytes) {
  EXPECT_TRUE(CheckedRemark(Times("停", kMaxRemarkCharacters)).ok());
  auto refused = CheckedRemark(Times("停", kMaxRemarkCharacters + 1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().field(), "text");
  EXPECT_NE(refused.status().message().find("found 501"), std::string::npos);
}

TEST(RemarkTest, WhatCannotBeReadIsRefused) {
  for (const char* text : {"", " \n\t ", "a\x1b[31m", "\xff", "a\u200bb", "a\U000e0041",
                           "a\xe2\x80\xae"
                           "b"}) {
    EXPECT_FALSE(CheckedRemark(text).ok()) << text;
  }
}

TEST(RemarkTest, WhatComesFromAServerIsBoundedAndHarmless) {
  wire::Remark message;
  message.set_id(7);
  message.set_text("\x1b]0;owned\x07\xff" + Times("停", 10'000));
  message.set_from(Times("x", 10'000) + "\n");
  message.set_sent_unix_ms(5);
  const Remark remark = ReadRemark(message);
  EXPECT_EQ(remark.id, 7u);
  EXPECT_EQ(remark.sent_unix_ms, 5);
  EXPECT_EQ(remark.text.find('\x1b'), std::string::npos);
  EXPECT_EQ(remark.text.find('\xff'), std::string::npos);
  EXPECT_LE(remark.text.size(), 3 * kMaxRemarkCharacters + 32);
  EXPECT_LE(remark.from.size(), kMaxRemarkSenderBytes);
}

TEST(RemarkTest, WireKeepsWhatMayBeSent) {
  const Remark sent{1'700'000'000'123, "请停一下", "Ada Lovelace", 1'700'000'000'100};
  wire::Remark message;
  SetRemark(sent, message);
  const Remark read = ReadRemark(message);
  EXPECT_EQ(read.id, sent.id);
  EXPECT_EQ(read.text, sent.text);
  EXPECT_EQ(read.from, sent.from);
  EXPECT_EQ(read.sent_unix_ms, sent.sent_unix_ms);
}

}  // namespace
}  // namespace enamel::protocol
