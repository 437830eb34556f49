#include "common/base/bytes.h"

#include <gtest/gtest.h>

#include <limits>

namespace enamel {
namespace {

TEST(BytesTest, EveryIntegerComesBackAsWritten) {
  ByteWriter out;
  out.U8(0xfe);
  out.U16(0xbeef);
  out.U32(0xdeadbeef);
  out.U64(0x0123456789abcdefull);
  out.I64(std::numeric_limits<int64_t>::min());
  out.SignedVarint(-1);
  out.Varint(std::numeric_limits<uint64_t>::max());
  out.SignedVarint(std::numeric_limits<int64_t>::min());
  ByteReader in(out.bytes());
  EXPECT_EQ(in.U8(), 0xfe);
  EXPECT_EQ(in.U16(), 0xbeef);
  EXPECT_EQ(in.U32(), 0xdeadbeef);
  EXPECT_EQ(in.U64(), 0x0123456789abcdefull);
  EXPECT_EQ(in.I64(), std::numeric_limits<int64_t>::min());
  EXPECT_EQ(in.SignedVarint(), -1);
  EXPECT_EQ(in.Varint(), std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(in.SignedVarint(), std::numeric_limits<int64_t>::min());
  EXPECT_TRUE(in.ok());
  EXPECT_TRUE(in.AtEnd());
}

TEST(BytesTest, IsLittleEndian) {
  ByteWriter out;
  out.U32(0x01020304);
  EXPECT_EQ(out.bytes(), (Bytes{4, 3, 2, 1}));
}

TEST(BytesTest, ReadingPastTheEndFailsForGoodAndReturnsZero) {
  Bytes three = {1, 2, 3};
  ByteReader in(three);
  EXPECT_EQ(in.U32(), 0u);
  EXPECT_FALSE(in.ok());
  EXPECT_EQ(in.U8(), 0);
  EXPECT_TRUE(in.Raw(1).empty());
}

TEST(BytesTest, BlobLongerThanAllowedOrThanTheInputIsRefused) {
  ByteWriter out;
  out.Blob(Bytes(10, 7));
  ByteReader limited(out.bytes());
  EXPECT_TRUE(limited.Blob(9).empty());
  EXPECT_FALSE(limited.ok());
  Bytes lying = {0xff, 0xff, 0xff, 0x7f, 1};
  ByteReader in(lying);
  EXPECT_TRUE(in.Blob(size_t{1} << 40).empty());
  EXPECT_FALSE(in.ok());
}

TEST(BytesTest, VarintOfMoreThanSixtyFourBitsIsRefused) {
  Bytes eleven(11, 0x80);
  ByteReader in(eleven);
  in.Varint();
  EXPECT_FALSE(in.ok());
  Bytes overflow(9, 0xff);
  overflow.push_back(2);
  ByteReader over(overflow);
  over.Varint();
  EXPECT_FALSE(over.ok());
}

}  // namespace
}  // namespace enamel
