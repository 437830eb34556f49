#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <random>

#include "common/base/hex.h"
#include "common/trace/columns.h"
#include "common/trace/trace.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

constexpr size_t kSignatureBytes = 64;
constexpr size_t kCountAt = 34;  // schemas/trace_format.md, "Chunk"
constexpr size_t kPayloadSizeAt = 82;

template <typename T>
T Any(std::mt19937_64& random) {
  // Extremes often: that is where a codec breaks.
  switch (random() % 4) {
    case 0:
      return std::numeric_limits<T>::min();
    case 1:
      return std::numeric_limits<T>::max();
    default:
      return static_cast<T>(random());
  }
}

Tick AnyTick(std::mt19937_64& random) {
  Tick t;
  for (auto& v : t.input.counts) v = Any<int32_t>(random);
  for (auto& v : t.input.orientation) v = Any<int16_t>(random);
  t.input.flags = Any<uint8_t>(random);
  t.input.bur_speed_krpm = Any<uint16_t>(random);
  t.input.gap_ticks = Any<uint32_t>(random);
  for (auto& v : t.witness.force_sent_mn) v = Any<int32_t>(random);
  for (auto& v : t.witness.force_computed_mn) v = Any<int32_t>(random);
  for (auto& v : t.witness.anchor_100nm) v = Any<int32_t>(random);
  t.witness.flags = Any<uint16_t>(random);
  for (auto& v : t.input.rest_off_nm) v = Any<int32_t>(random);
  t.input.share_lost = Any<uint16_t>(random);
  return t;
}

ChunkHead AnyHead() {
  ChunkHead head;
  head.attempt.bytes.fill(7);
  head.seq = 3;
  head.first_tick = 1234;
  head.state_hash = 0x0123456789abcdefull;
  head.previous.bytes.fill(9);
  return head;
}

Bytes SmallChunk(size_t ticks) {
  return EncodeChunk(AnyHead(), std::vector<Tick>(ticks), sample::StationKeys().secret_key);
}

class ChunkOfSizeTest : public testing::TestWithParam<size_t> {};

TEST_P(ChunkOfSizeTest, GivesBackEveryBitOfExtremeValues) {
  std::mt19937_64 random(GetParam());
  std::vector<Tick> ticks;
  for (size_t i = 0; i < GetParam(); ++i) ticks.push_back(AnyTick(random));
  Bytes bytes = EncodeChunk(AnyHead(), ticks, sample::StationKeys().secret_key);
  EXPECT_LE(bytes.size(), kMaxChunkBytes);
  auto chunk = DecodeChunk(bytes);
  ASSERT_TRUE(chunk.ok()) << chunk.status().message();
  EXPECT_EQ(chunk->ticks, ticks);
  EXPECT_EQ(chunk->head.count, ticks.size());
  EXPECT_EQ(chunk->head.seq, 3u);
  EXPECT_EQ(chunk->head.first_tick, 1234u);
  EXPECT_EQ(chunk->head.state_hash, 0x0123456789abcdefull);
  EXPECT_EQ(chunk->hash, HashSha256(ByteView(bytes).first(bytes.size() - kSignatureBytes)));
}

INSTANTIATE_TEST_SUITE_P(Sizes, ChunkOfSizeTest, testing::Values(1, 2, 3, 4, 17, 500, 1000));

TEST(ChunkTest, HeadAloneAgreesWithFullDecodingAndHasNoTicks) {
  auto recording = sample::Record(sample::CutInputs(300), 300);
  auto head = DecodeChunkHead(recording.chunks[0]);
  auto full = DecodeChunk(recording.chunks[0]);
  ASSERT_TRUE(head.ok() && full.ok());
  EXPECT_EQ(head->head, full->head);
  EXPECT_EQ(head->hash, full->hash);
  EXPECT_TRUE(head->ticks.empty());
}

TEST(ChunkTest, GapsAreAddedUpAndHeldAtTheLargestNumber) {
  std::vector<Tick> ticks(3);
  ticks[0].input.gap_ticks = 5;
  ticks[2].input.gap_ticks = 7;
  auto key = sample::StationKeys().secret_key;
  EXPECT_EQ(DecodeChunk(EncodeChunk({}, ticks, key))->head.gap_ticks, 12u);
  ticks[1].input.gap_ticks = std::numeric_limits<uint32_t>::max();
  EXPECT_EQ(DecodeChunk(EncodeChunk({}, ticks, key))->head.gap_ticks,
            std::numeric_limits<uint32_t>::max());
}

TEST(ChunkTest, EveryTruncationIsRefused) {
  Bytes bytes = SmallChunk(40);
  for (size_t n = 0; n < bytes.size(); ++n) {
    ByteView cut = ByteView(bytes).first(n);
    EXPECT_FALSE(DecodeChunkHead(cut).ok()) << n;
    EXPECT_FALSE(DecodeChunk(cut).ok()) << n;
    EXPECT_FALSE(VerifyChunk(cut, sample::StationKeys().public_key)) << n;
  }
}

TEST(ChunkTest, EveryTruncationOfThePayloadIsRefused) {
  std::vector<Tick> ticks(20);
  Bytes payload = EncodeColumns(ticks);
  ASSERT_TRUE(DecodeColumns(payload, 20).ok());
  for (size_t n = 0; n < payload.size(); ++n) {
    EXPECT_FALSE(DecodeColumns(ByteView(payload).first(n), 20).ok()) << n;
  }
  payload.push_back(0);
  EXPECT_FALSE(DecodeColumns(payload, 20).ok());
}

TEST(ChunkTest, NoTicksHaveAPayloadToo) {
  const Bytes payload = EncodeColumns({});
  EXPECT_EQ(payload.size(), kColumnCount - 3) << "a coding for each column";
  EXPECT_TRUE(DecodeColumns(payload, 0)->empty());
}

TEST(ChunkTest, NoBitCanBeChangedUnderTheSignature) {
  Bytes bytes = SmallChunk(10);
  auto key = sample::StationKeys().public_key;
  ASSERT_TRUE(VerifyChunk(bytes, key));
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    EXPECT_FALSE(VerifyChunk(bytes, key)) << bit;
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
}

TEST(ChunkTest, SignatureOfAnotherKeyIsRefused) {
  Bytes forged = EncodeChunk(AnyHead(), std::vector<Tick>(5), NewKeyPair().secret_key);
  EXPECT_FALSE(VerifyChunk(forged, sample::StationKeys().public_key));
}

TEST(ChunkTest, CountsOutsideOneToThousandAreRefusedBeforeAnythingIsUnpacked) {
  for (uint32_t count : {0u, 1001u, 0xffffffffu}) {
    Bytes bytes = SmallChunk(10);
    ByteWriter field;
    field.U32(count);
    std::copy(field.bytes().begin(), field.bytes().end(), bytes.begin() + kCountAt);
    auto chunk = DecodeChunkHead(bytes);
    ASSERT_FALSE(chunk.ok());
    EXPECT_EQ(chunk.status().field(), "count");
  }
}

TEST(ChunkTest, PayloadThatClaimsMoreThanItsTicksCanTakeIsRefused) {
  Bytes bytes = SmallChunk(10);
  ByteWriter field;
  field.U32(static_cast<uint32_t>(MaxPayloadBytes(10) + 1));
  std::copy(field.bytes().begin(), field.bytes().end(), bytes.begin() + kPayloadSizeAt);
  EXPECT_EQ(DecodeChunkHead(bytes).status().code(), Code::kTooLarge);
}

TEST(ChunkTest, PayloadThatUnpacksToAnotherSizeIsRefused) {
  for (int delta : {-1, 1}) {
    Bytes bytes = SmallChunk(10);
    bytes[kPayloadSizeAt] = static_cast<uint8_t>(bytes[kPayloadSizeAt] + delta);
    EXPECT_EQ(DecodeChunk(bytes).status().code(), Code::kInvalidInput);
  }
}

TEST(ChunkTest, OtherVersionIsNamedAsSuch) {
  Bytes bytes = SmallChunk(10);
  bytes[4] = 2;
  EXPECT_EQ(DecodeChunk(bytes).status().code(), Code::kVersion);
}

TEST(ChunkTest, ChunkOverAMebibyteIsRefused) {
  Bytes bytes = SmallChunk(10);
  bytes.resize(kMaxChunkBytes + 1);
  EXPECT_EQ(DecodeChunk(bytes).status().code(), Code::kTooLarge);
}

// Of so many ticks whose counts stay at 0 and whose columns are all of coding 0 and zeros, but for
// what `column` writes itself.
Bytes ZerosBut(size_t ticks, int column, const std::function<void(ByteWriter&)>& write) {
  ByteWriter payload;
  for (size_t i = 0; i < (ticks + 7) / 8; ++i) payload.U8(0);
  for (int c = 3; c < 24; ++c) {
    if (c == column) {
      write(payload);
      continue;
    }
    payload.U8(0);
    for (size_t i = 0; i < ticks; ++i) payload.SignedVarint(0);
  }
  return payload.Take();
}

TEST(ChunkTest, ValueOutsideItsFieldIsRefusedWithTheColumnsName) {
  const auto ticks = DecodeColumns(ZerosBut(1, 7,
                                            [](ByteWriter& out) {
                                              out.U8(0);
                                              out.SignedVarint(256);  // input flags are one byte
                                            }),
                                   1);
  ASSERT_FALSE(ticks.ok());
  EXPECT_EQ(ticks.status().field(), "input flags");
}

TEST(ChunkTest, AnUnknownCodingIsRefused) {
  auto coded = [](int column, uint8_t coding, int64_t slope) {
    return DecodeColumns(ZerosBut(2, column,
                                  [&](ByteWriter& out) {
                                    out.U8(coding);
                                    if (coding == 4) out.SignedVarint(slope);
                                    if (coding == 4) out.SignedVarint(-slope);
                                    out.SignedVarint(0);
                                    out.SignedVarint(0);
                                  }),
                         2);
  };
  EXPECT_TRUE(coded(9, 3, 0).ok());
  for (int column : {3, 9, 16, 19, 23}) EXPECT_FALSE(coded(column, 4, 0).ok()) << column;
  for (int column = 10; column <= 15; ++column) {
    EXPECT_TRUE(coded(column, 4, 1 << 24).ok()) << column;
    EXPECT_FALSE(coded(column, 4, (1 << 24) + 1).ok()) << column;
    EXPECT_FALSE(coded(column, 5, 0).ok()) << column;
  }
}

TEST(ChunkTest, AMarkOfATickThatIsNotThereIsRefused) {
  Bytes payload = EncodeColumns(std::vector<Tick>(3));
  ASSERT_TRUE(DecodeColumns(payload, 3).ok());
  payload[0] = 1 << 3;
  const auto ticks = DecodeColumns(payload, 3);
  ASSERT_FALSE(ticks.ok());
  EXPECT_EQ(ticks.status().field(), "counts");
}

TEST(ChunkTest, PayloadMatchesTheSpecificationByHand) {
  // Counts x 5, 5 and then 4, everything else zero but orientation w = 32767.
  std::vector<Tick> ticks(3);
  for (Tick& tick : ticks) tick.input.counts[0] = 5;
  ticks[2].input.counts[0] = 4;
  // The first and the third tick move: 5, then -1.
  std::string expected =
      "05"
      "0a0000"
      "010000";
  for (int i = 0; i < 3; ++i) expected += "00000000";
  expected += "01feff030000";  // first differences: zigzag 65534, 0, 0
  for (int i = 0; i < 17; ++i) expected += "00000000";
  EXPECT_EQ(ToHex(EncodeColumns(ticks)), expected);
}

// Counts move by 64 in the second tick and by 10 in the third. The anchor's slopes are 1/2 along
// its own way and 1/4 along the counts', the force's 1 along the counts' and -2 along the anchor's.
TEST(ChunkTest, WhatAnchorAndForceFollowIsWhatTheSpecificationSays) {
  ByteWriter out;
  out.U8(0b110);
  for (int64_t way : {64, 0, 0, 10, 0, 0}) out.SignedVarint(way);
  for (int column = 3; column < 24; ++column) {
    const bool follows = column == 10 || column == 13;
    out.U8(follows ? 4 : 0);
    if (column == 10) out.SignedVarint(1 << 15), out.SignedVarint(1 << 14);
    if (column == 13) out.SignedVarint(1 << 16), out.SignedVarint(-(2 << 16));
    for (int64_t left : {column == 10 ? 100 : 0, follows ? 1 : 0, follows ? -3 : 0}) {
      out.SignedVarint(left);
    }
  }
  const auto ticks = DecodeColumns(out.bytes(), 3);
  ASSERT_TRUE(ticks.ok()) << ticks.status().message();
  // 100; + 64 / 4 + 1; + round(17 / 2 + 10 / 4) - 3.
  EXPECT_EQ((*ticks)[0].witness.anchor_100nm[0], 100);
  EXPECT_EQ((*ticks)[1].witness.anchor_100nm[0], 117);
  EXPECT_EQ((*ticks)[2].witness.anchor_100nm[0], 125);
  // 0; + 64 - 2 * 17 + 1; + 10 - 2 * 8 - 3.
  EXPECT_EQ((*ticks)[1].witness.force_sent_mn[0], 31);
  EXPECT_EQ((*ticks)[2].witness.force_sent_mn[0], 22);
}

TEST(ChunkTest, RealisticCutTakesAtMostTwoBytesPerTick) {
  auto recording = sample::Record(sample::CutInputs(6000), 500);
  size_t bytes = 0, payload = 0;
  for (const Bytes& chunk : recording.chunks) bytes += chunk.size();
  for (size_t i = 0; i < recording.ticks.size(); i += 500) {
    payload += EncodeColumns(std::span<const Tick>(recording.ticks).subspan(i, 500)).size();
  }
  auto ticks = static_cast<double>(recording.ticks.size());
  std::printf("%.0f ticks: %.2f bytes per tick in chunks of 500, %.2f before zstd\n", ticks,
              static_cast<double>(bytes) / ticks, static_cast<double>(payload) / ticks);
  EXPECT_LE(static_cast<double>(bytes) / ticks, 2.0);
}

}  // namespace
}  // namespace enamel::trace
