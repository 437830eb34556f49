#include "common/base/packed.h"

#include <gtest/gtest.h>

#include <string>

namespace enamel {
namespace {

TEST(PackedTest, BytesComeBack) {
  const std::string text(100'000, 'a');
  const Bytes packed = Pack(AsBytes(text), 3);
  EXPECT_LT(packed.size(), 1000u);
  EXPECT_EQ(AsText(*Unpack(packed, text.size(), "it")), text);
  EXPECT_TRUE(Unpack(Pack({}, 3), 0, "it")->empty());
}

TEST(PackedTest, AnotherSizeIsRefusedAndSaysWhich) {
  const Bytes packed = Pack(AsBytes("0123456789"), 3);
  for (size_t size : {size_t{0}, size_t{9}, size_t{11}, size_t{1} << 40}) {
    const auto found = Unpack(packed, size, "it");
    ASSERT_EQ(found.status().code(), Code::kInvalidInput) << size;
    EXPECT_NE(found.status().message().find("it cannot be unpacked: expected"), std::string::npos);
  }
}

TEST(PackedTest, WhatIsNoFrameOrEndsEarlyIsRefused) {
  const Bytes packed = Pack(AsBytes("0123456789 0123456789 0123456789"), 3);
  EXPECT_FALSE(Unpack(AsBytes("no frame"), 32, "it").ok());
  for (size_t n = 0; n < packed.size(); ++n) {
    EXPECT_FALSE(Unpack(ByteView(packed).first(n), 32, "it").ok()) << n;
  }
}

}  // namespace
}  // namespace enamel
