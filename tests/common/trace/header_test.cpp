#include <gtest/gtest.h>

#include <algorithm>

#include "common/trace/trace.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

TEST(TicketTest, GivesBackWhatWasWritten) {
  Ticket ticket = sample::MakeHeader().ticket;
  Bytes bytes = EncodeTicket(ticket);
  EXPECT_EQ(bytes.size(), 214u);
  auto read = DecodeTicket(bytes);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*read, ticket);
}

TEST(TicketTest, NoBitCanBeChangedUnderTheSignature) {
  Bytes bytes = EncodeTicket(sample::MakeHeader().ticket);
  auto key = sample::ServerKeys().public_key;
  ASSERT_TRUE(VerifyTicket(*DecodeTicket(bytes), key));
  for (size_t bit = 6 * 8; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    EXPECT_FALSE(VerifyTicket(*DecodeTicket(bytes), key)) << bit;
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
}

TEST(TicketTest, SignedByAnybodyButTheServerIsRefused) {
  Ticket ticket = sample::MakeHeader().ticket;
  SignTicket(ticket, sample::StationKeys().secret_key);
  EXPECT_FALSE(VerifyTicket(ticket, sample::ServerKeys().public_key));
}

TEST(TicketTest, EveryTruncationAndAnExtraByteAreRefused) {
  Bytes bytes = EncodeTicket(sample::MakeHeader().ticket);
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(DecodeTicket(ByteView(bytes).first(n)).ok());
  bytes.push_back(0);
  EXPECT_FALSE(DecodeTicket(bytes).ok());
}

TEST(HeaderTest, GivesBackWhatWasWritten) {
  Header header = sample::MakeHeader();
  auto read = DecodeHeader(EncodeHeader(header));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*read, header);
}

TEST(HeaderTest, EveryTruncationAndAnExtraByteAreRefused) {
  Bytes bytes = EncodeHeader(sample::MakeHeader());
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(DecodeHeader(ByteView(bytes).first(n)).ok());
  bytes.push_back(0);
  EXPECT_FALSE(DecodeHeader(bytes).ok());
}

TEST(HeaderTest, AnotherVersionIsRefused) {
  Bytes bytes = EncodeHeader(sample::MakeHeader());
  for (uint8_t version : {0, 2, 255}) {
    bytes[4] = version;
    EXPECT_EQ(DecodeHeader(bytes).status().code(), Code::kVersion) << int{version};
  }
}

// What earlier programs wrote begins with other letters.
TEST(HeaderTest, AnEarlierEnamelsIsRefusedByItsLetters) {
  Bytes bytes = EncodeHeader(sample::MakeHeader());
  std::ranges::copy(AsBytes("ENhd"), bytes.begin());
  const Status refused = DecodeHeader(bytes).status();
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("begin with ENah, found ENhd"), std::string::npos)
      << refused.message();
  EXPECT_NE(refused.message().find("an earlier Enamel"), std::string::npos) << refused.message();
}

TEST(HeaderTest, KnowsThreeKindsOfHandAndNoOther) {
  Bytes bytes = EncodeHeader(sample::MakeHeader());
  const size_t kind_at = bytes.size() - (4 + 16) - (4 + 3) - (4 + 7) - 1;
  ASSERT_EQ(bytes[kind_at], 1);
  for (int kind = 0; kind < 256; ++kind) {
    bytes[kind_at] = static_cast<uint8_t>(kind);
    EXPECT_EQ(DecodeHeader(bytes).ok(), kind >= 1 && kind <= 3) << kind;
  }
}

TEST(HeaderTest, WhatIsAcceptedEncodesToTheSameBytes) {
  // Otherwise the hash of a stored header and of the decoded one would differ.
  Bytes bytes = EncodeHeader(sample::MakeHeader());
  int accepted = 0;
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    if (auto header = DecodeHeader(bytes); header.ok()) {
      ++accepted;
      EXPECT_EQ(EncodeHeader(*header), bytes) << bit;
    }
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
  EXPECT_GT(accepted, 1000);
}

TEST(HeaderTest, RecordingOfAnotherCoreVersionIsReadAndNotReplayed) {
  Header header = sample::MakeHeader();
  header.params.core_version = core::kCoreVersion + 1;
  auto read = DecodeHeader(EncodeHeader(header));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->params, header.params);
  EXPECT_EQ(core::ValidateParams(read->params).code(), Code::kVersion);
}

TEST(HeaderTest, OverFourKibibytesIsRefused) {
  EXPECT_EQ(DecodeHeader(Bytes(kMaxHeaderBytes + 1)).status().code(), Code::kTooLarge);
}

TEST(SealTest, GivesBackWhatWasWrittenAndRefusesAnyOtherLength) {
  Seal seal{Uuid::New(), 7, 3500, HashSha256(AsBytes("x")), 99};
  Bytes bytes = EncodeSeal(seal);
  ASSERT_TRUE(DecodeSeal(bytes).ok());
  EXPECT_EQ(*DecodeSeal(bytes), seal);
  for (size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(DecodeSeal(ByteView(bytes).first(n)).ok());
  bytes.push_back(0);
  EXPECT_FALSE(DecodeSeal(bytes).ok());
}

TEST(KeyPairTest, EqualsTheFirstVectorOfRfc8032) {
  std::array<uint8_t, 32> seed = {0x9d, 0x61, 0xb1, 0x9d, 0xef, 0xfd, 0x5a, 0x60, 0xba, 0x84, 0x4a,
                                  0xf4, 0x92, 0xec, 0x2c, 0xc4, 0x44, 0x49, 0xc5, 0x69, 0x7b, 0x32,
                                  0x69, 0x19, 0x70, 0x3b, 0xac, 0x03, 0x1c, 0xae, 0x7f, 0x60};
  PublicKey expected = {0xd7, 0x5a, 0x98, 0x01, 0x82, 0xb1, 0x0a, 0xb7, 0xd5, 0x4b, 0xfe,
                        0xd3, 0xc9, 0x64, 0x07, 0x3a, 0x0e, 0xe1, 0x72, 0xf3, 0xda, 0xa6,
                        0x23, 0x25, 0xaf, 0x02, 0x1a, 0x68, 0xf7, 0x07, 0x51, 0x1a};
  EXPECT_EQ(KeyPairFromSeed(seed).public_key, expected);
  EXPECT_NE(NewKeyPair().public_key, NewKeyPair().public_key);
}

}  // namespace
}  // namespace enamel::trace
