#include <gtest/gtest.h>

#include "common/base/hex.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"

namespace enamel {
namespace {

// FIPS 180-2, appendix B.1.
TEST(Sha256Test, AgreesWithThePublishedVector) {
  EXPECT_EQ(HashSha256(AsBytes("abc")).Hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256Test, StreamAgreesWithOneCall) {
  Sha256Stream stream;
  stream.Update(AsBytes("a"));
  stream.Update(AsBytes("bc"));
  EXPECT_EQ(stream.Finish(), HashSha256(AsBytes("abc")));
}

TEST(Sha256Test, TextThatIsNoDigestIsRefused) {
  EXPECT_FALSE(Sha256::FromHex("ba78").ok());
  EXPECT_FALSE(Sha256::FromHex(std::string(64, 'g')).ok());
}

TEST(UuidTest, IsVersionSevenSortsByTimeAndComesBackFromText) {
  using std::chrono::milliseconds;
  auto t = std::chrono::system_clock::time_point(milliseconds(1'700'000'000'000));
  Uuid early = Uuid::New(t), late = Uuid::New(t + milliseconds(1));
  EXPECT_LT(early, late);
  EXPECT_EQ(early.bytes[6] >> 4, 7);
  EXPECT_EQ(early.bytes[8] >> 6, 2);
  EXPECT_EQ(Uuid::Parse(early.Text()).value(), early);
}

TEST(UuidTest, IdsOfOneMillisecondKeepTheirOrder) {
  auto t = std::chrono::system_clock::time_point(std::chrono::milliseconds(1'700'000'000'001));
  Uuid last = Uuid::New(t);
  for (int i = 0; i < 3000; ++i) {
    Uuid next = Uuid::New(t);
    ASSERT_LT(last, next) << i;
    last = next;
  }
}

TEST(UuidTest, MalformedTextIsRefused) {
  for (const char* text : {"", "0123", "01234567-89ab-7cde-8f01-23456789abcg",
                           "0123456789ab-7cde-8f01-23456789abcdef-"}) {
    EXPECT_FALSE(Uuid::Parse(text).ok()) << text;
  }
}

TEST(HexTest, OddLengthAndStrangeDigitsAreRefused) {
  EXPECT_FALSE(FromHex("abc").ok());
  EXPECT_FALSE(FromHex("zz").ok());
  EXPECT_EQ(FromHex("00fF").value(), (Bytes{0, 255}));
}

}  // namespace
}  // namespace enamel
