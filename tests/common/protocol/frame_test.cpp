#include "common/protocol/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace enamel::protocol {
namespace {

// Gives the reader `stream` in pieces that end at the given places, as a socket would.
Result<std::vector<Bytes>> ReadIn(ByteView stream, const std::vector<size_t>& ends,
                                  size_t limit = kMaxFrameBytes) {
  FrameReader reader(limit);
  std::vector<Bytes> messages;
  size_t at = 0;
  for (size_t end : ends) {
    while (at < end) {
      auto space = reader.Prepare();
      size_t n = std::min(space.size(), end - at);
      std::copy_n(stream.begin() + static_cast<long>(at), n, space.begin());
      at += n;
      ENAMEL_RETURN_IF_ERROR(reader.Resume(n));
      if (reader.done()) messages.push_back(reader.Take());
    }
  }
  return messages;
}

Bytes TwoFrames(const Bytes& a, const Bytes& b) {
  Bytes stream = *EncodeFrame(a);
  Bytes second = *EncodeFrame(b);
  stream.insert(stream.end(), second.begin(), second.end());
  return stream;
}

const Bytes kFirst = {1, 2, 3, 4, 5};
const Bytes kSecond = {9, 8, 7};

TEST(FrameTest, IsLengthInFourLittleEndianBytesAndThenTheMessage) {
  EXPECT_EQ(*EncodeFrame(kSecond), (Bytes{3, 0, 0, 0, 9, 8, 7}));
  Bytes long_message(0x01020304 % kMaxFrameBytes);
  EXPECT_EQ(ByteReader(*EncodeFrame(long_message)).U32(), long_message.size());
}

TEST(FrameReaderTest, AcceptsMessagesSplitAtEveryByte) {
  Bytes stream = TwoFrames(kFirst, kSecond);
  for (size_t split = 0; split <= stream.size(); ++split) {
    auto messages = ReadIn(stream, {split, stream.size()});
    ASSERT_TRUE(messages.ok());
    EXPECT_EQ(*messages, (std::vector<Bytes>{kFirst, kSecond})) << split;
  }
}

TEST(FrameReaderTest, AcceptsMessagesSplitAtEveryPairOfBytes) {
  Bytes stream = TwoFrames(kFirst, kSecond);
  for (size_t a = 0; a <= stream.size(); ++a) {
    for (size_t b = a; b <= stream.size(); ++b) {
      EXPECT_EQ(*ReadIn(stream, {a, b, stream.size()}), (std::vector<Bytes>{kFirst, kSecond}));
    }
  }
}

TEST(FrameReaderTest, AcceptsMessagesOneByteAtATime) {
  Bytes stream = TwoFrames(kFirst, kSecond);
  std::vector<size_t> ends;
  for (size_t i = 1; i <= stream.size(); ++i) ends.push_back(i);
  EXPECT_EQ(*ReadIn(stream, ends), (std::vector<Bytes>{kFirst, kSecond}));
}

TEST(FrameReaderTest, AcceptsAnEmptyMessage) {
  Bytes stream = TwoFrames({}, kFirst);
  EXPECT_EQ(*ReadIn(stream, {stream.size()}), (std::vector<Bytes>{{}, kFirst}));
}

TEST(FrameReaderTest, AcceptsTheLongestMessageAndRefusesOneByteMore) {
  Bytes longest(kMaxFrameBytes, 0x5a);
  Bytes stream = *EncodeFrame(longest);
  auto messages = ReadIn(stream, {stream.size()});
  ASSERT_TRUE(messages.ok());
  EXPECT_EQ(messages->at(0), longest);

  longest.push_back(0);
  EXPECT_EQ(EncodeFrame(longest).status().code(), Code::kTooLarge);
  ByteWriter length;
  length.U32(kMaxFrameBytes + 1);
  EXPECT_EQ(ReadIn(length.bytes(), {4}).status().code(), Code::kTooLarge);
}

TEST(FrameReaderTest, TakesNoMemoryForALengthThatOnlyPromises) {
  FrameReader reader;
  ByteWriter length;
  length.U32(kMaxFrameBytes);
  auto space = reader.Prepare();
  std::copy(length.bytes().begin(), length.bytes().end(), space.begin());
  ASSERT_TRUE(reader.Resume(4).ok());
  EXPECT_LE(reader.Prepare().size(), size_t{64} << 10);
}

TEST(FrameReaderTest, NeverAsksForABeyondTheFrame) {
  Bytes stream = TwoFrames(kFirst, kSecond);
  FrameReader reader;
  size_t at = 0;
  while (!reader.done()) {
    auto space = reader.Prepare();
    ASSERT_GT(space.size(), 0u);
    std::copy_n(stream.begin() + static_cast<long>(at), space.size(), space.begin());
    at += space.size();
    ASSERT_TRUE(reader.Resume(space.size()).ok());
  }
  EXPECT_EQ(at, 4 + kFirst.size());
  EXPECT_FALSE(reader.at_boundary());
  reader.Take();
  EXPECT_TRUE(reader.at_boundary());
}

TEST(FrameReaderTest, LimitBeforeHelloIsRaisedAfterIt) {
  FrameReader reader(kMaxFrameBytesBeforeHello);
  ByteWriter length;
  length.U32(kMaxFrameBytesBeforeHello + 1);
  auto give = [&] {
    auto space = reader.Prepare();
    std::copy(length.bytes().begin(), length.bytes().end(), space.begin());
    return reader.Resume(4);
  };
  EXPECT_FALSE(give().ok());
  reader = FrameReader(kMaxFrameBytesBeforeHello);
  reader.set_limit(kMaxFrameBytes);
  EXPECT_TRUE(give().ok());
}

}  // namespace
}  // namespace enamel::protocol
