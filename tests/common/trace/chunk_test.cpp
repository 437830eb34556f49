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

TEST(ChunkTest, ValueOutsideItsFieldIsRefusedWithTheColumnsName) {
  ByteWriter payload;
  for (int column = 0; column < 20; ++column) {
    payload.U8(0);
    payload.SignedVarint(column == 7 ? 256 : 0);  // input flags are one byte
  }
  auto ticks = DecodeColumns(payload.bytes(), 1);
  ASSERT_FALSE(ticks.ok());
  EXPECT_EQ(ticks.status().field(), "input flags");
}

TEST(ChunkTest, DifferenceOrderOverThreeIsRefused) {
  Bytes payload = EncodeColumns(std::vector<Tick>(2));
  payload[0] = 4;
  EXPECT_FALSE(DecodeColumns(payload, 2).ok());
}

TEST(ChunkTest, PayloadMatchesTheSpecificationByHand) {
  // Two ticks: counts x 5 then 4, everything else zero but orientation w = 32767.
  std::vector<Tick> ticks(2);
  ticks[0].input.counts[0] = 5;
  ticks[1].input.counts[0] = 4;
  std::string expected = "000a08";  // order 0: zigzag 5, 4
  for (int i = 0; i < 5; ++i) expected += "000000";
  expected += "01feff0300";  // order 1: zigzag 65534, 0
  for (int i = 0; i < 17; ++i) expected += "000000";
  EXPECT_EQ(ToHex(EncodeColumns(ticks)), expected);
}

TEST(ChunkTest, RealisticCutTakesAtMostTwelveBytesPerTick) {
  auto recording = sample::Record(sample::CutInputs(6000), 500);
  size_t bytes = 0, payload = 0;
  for (const Bytes& chunk : recording.chunks) bytes += chunk.size();
  for (size_t i = 0; i < recording.ticks.size(); i += 500) {
    payload += EncodeColumns(std::span<const Tick>(recording.ticks).subspan(i, 500)).size();
  }
  auto ticks = static_cast<double>(recording.ticks.size());
  std::printf("%.0f ticks: %.2f bytes per tick in chunks of 500, %.2f before zstd\n", ticks,
              static_cast<double>(bytes) / ticks, static_cast<double>(payload) / ticks);
  EXPECT_LE(static_cast<double>(bytes) / ticks, 12.0);
}

}  // namespace
}  // namespace enamel::trace
