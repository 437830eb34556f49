#include "common/trace/keyframes.h"

#include <gtest/gtest.h>

#include "common/trace/layout.h"
#include "common/trace/moment.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

constexpr size_t kTicks = 3000, kPerChunk = 100;

const sample::Recording& Attempt() {
  static const sample::Recording recording = sample::Record(sample::CutInputs(kTicks), kPerChunk);
  return recording;
}

Sha256 HeaderHash(const sample::Recording& r) { return HashSha256(EncodeHeader(r.header)); }

std::unique_ptr<core::Core> MakeCore() {
  return std::make_unique<core::Core>(sample::MakeHeader().params, sample::MakeBlock());
}

// The truth: stepped directly, tick by tick.
std::unique_ptr<core::Core> SteppedTo(const sample::Recording& r, uint64_t tick) {
  auto core = MakeCore();
  for (size_t i = 0; i < tick && i < r.ticks.size(); ++i) core->Step(r.ticks[i].input);
  return core;
}

Result<Moment> Reach(const sample::Recording& r, uint64_t tick, Keyframes& keyframes,
                     bool from_keyframe = true) {
  MomentOptions options;
  options.to_tick = tick;
  options.start_from_keyframe = from_keyframe;
  options.keyframe_every_s = 0;
  return ReplayToMoment(MakeCore, r.header, r.chunks, options, keyframes);
}

Keyframes KeyframesOf(const sample::Recording& r) {
  Keyframes keyframes(HeaderHash(r));
  ENAMEL_CHECK(Reach(r, UINT64_MAX, keyframes).ok());
  return keyframes;
}

void ExpectTruth(const Moment& moment, const core::Core& truth) {
  EXPECT_TRUE(moment.report.witness_ok) << moment.report.what;
  EXPECT_EQ(moment.core->ticks(), truth.ticks());
  EXPECT_EQ(moment.report.ticks, truth.ticks());
  EXPECT_EQ(moment.core->state_hash(), truth.state_hash());
  EXPECT_EQ(moment.core->removed(), truth.removed());
  EXPECT_TRUE(moment.core->volume() == truth.volume());
}

TEST(MomentTest, EveryMomentHasTheStateOfARunFromTheStart) {
  Keyframes made = KeyframesOf(Attempt());
  EXPECT_EQ(made.size(), kTicks / kPerChunk);
  auto keyframes = Keyframes::Decode(made.Encode(), HeaderHash(Attempt()));
  ASSERT_TRUE(keyframes.ok()) << keyframes.status().message();
  for (uint64_t tick : {0u, 1u, 99u, 100u, 101u, 850u, 1234u, 1999u, 2000u, 2999u, 3000u, 9999u}) {
    auto moment = Reach(Attempt(), tick, *keyframes);
    ASSERT_TRUE(moment.ok()) << moment.status().message();
    ExpectTruth(*moment, *SteppedTo(Attempt(), tick));
    EXPECT_EQ(moment->whole, tick >= kTicks);
    EXPECT_TRUE(moment->discarded.empty()) << moment->discarded;
    // At least one whole chunk is re-run and compared, never more than two.
    if (tick >= 2 * kPerChunk) {
      uint64_t end = moment->report.ticks;
      EXPECT_GT(moment->from_tick, 0u);
      EXPECT_GE(end - moment->from_tick, kPerChunk) << tick;
      EXPECT_LT(end - moment->from_tick, 2 * kPerChunk) << tick;
    }
  }
}

TEST(MomentTest, VerificationStartsAtTheFirstTickWhateverKeyframesThereAre) {
  Keyframes keyframes = KeyframesOf(Attempt());
  auto moment = Reach(Attempt(), UINT64_MAX, keyframes, false);
  ASSERT_TRUE(moment.ok());
  EXPECT_EQ(moment->from_tick, 0u);
  EXPECT_EQ(keyframes.size(), kTicks / kPerChunk);
  EXPECT_EQ(moment->report.state_hash, Attempt().seal.state_hash);
}

TEST(MomentTest, KeyframesOfTheFirstHalfServeTheWholeAndAreContinued) {
  sample::Recording half = Attempt();
  half.chunks.resize(half.chunks.size() / 2);
  Keyframes keyframes(HeaderHash(half));
  ASSERT_TRUE(Reach(half, UINT64_MAX, keyframes).ok());
  ASSERT_EQ(keyframes.size(), half.chunks.size());
  auto moment = Reach(Attempt(), UINT64_MAX, keyframes);
  ASSERT_TRUE(moment.ok());
  EXPECT_GE(moment->from_tick, kTicks / 2 - 2 * kPerChunk);
  EXPECT_EQ(keyframes.size(), Attempt().chunks.size());
  auto again = Reach(Attempt(), kTicks - 50, keyframes);
  ASSERT_TRUE(again.ok());
  ExpectTruth(*again, *SteppedTo(Attempt(), kTicks - 50));
}

TEST(MomentTest, KeyframesOfOtherChunksUnderTheSameHeaderAreDropped) {
  auto inputs = sample::CutInputs(kTicks);
  for (size_t i = 1500; i < kTicks; ++i) inputs[i].counts[0] += 3;
  sample::Recording other = sample::Record(inputs, kPerChunk);
  ASSERT_EQ(HeaderHash(other), HeaderHash(Attempt()));
  Keyframes keyframes = KeyframesOf(other);
  auto moment = Reach(Attempt(), 2500, keyframes);
  ASSERT_TRUE(moment.ok()) << moment.status().message();
  EXPECT_FALSE(moment->discarded.empty());
  EXPECT_EQ(moment->from_tick, 0u);
  ExpectTruth(*moment, *SteppedTo(Attempt(), 2500));
  // Also where the replay starts at 0 and meets them on its way.
  keyframes = KeyframesOf(other);
  ASSERT_TRUE(Reach(Attempt(), 2500, keyframes, false).ok());
  auto again = Reach(Attempt(), 2400, keyframes);
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again->discarded.empty()) << again->discarded;
  ExpectTruth(*again, *SteppedTo(Attempt(), 2400));
}

// Right hash, right scalars, wrong tooth: only re-running shows it.
TEST(MomentTest, WrongToothInAKeyframeIsFoundByTheWitnessAndTheReplayStartsAgain) {
  const sample::Recording& r = Attempt();
  Keyframes honest = KeyframesOf(r);
  auto core = SteppedTo(r, 2000);
  Keyframes wrong(HeaderHash(r));
  wrong.Add(*core, honest.place(19), {});  // no brick changed in 2000 ticks of cutting
  auto moment = Reach(r, 2900, wrong);
  ASSERT_TRUE(moment.ok()) << moment.status().message();
  EXPECT_NE(moment->discarded.find("disagrees"), std::string::npos) << moment->discarded;
  ExpectTruth(*moment, *SteppedTo(r, 2900));
}

TEST(MomentTest, RecordingThatDisagreesWithTheCoreIsToldFromBadKeyframes) {
  sample::Recording r = Attempt();
  Keyframes keyframes = KeyframesOf(r);
  r.ticks[2550].witness.anchor_100nm[1] += 1;
  std::span<const Tick> ticks(r.ticks);
  Sha256 previous = DecodeChunkHead(r.chunks[24])->hash;
  for (size_t c = 25; c < r.chunks.size(); ++c) {
    ChunkHead head = DecodeChunkHead(r.chunks[c])->head;
    head.previous = previous;
    r.chunks[c] = EncodeChunk(head, ticks.subspan(c * kPerChunk, kPerChunk),
                              sample::StationKeys().secret_key);
    previous = DecodeChunkHead(r.chunks[c])->hash;
  }
  keyframes.Truncate(25);
  auto moment = Reach(r, 2700, keyframes);
  ASSERT_TRUE(moment.ok()) << moment.status().message();
  EXPECT_FALSE(moment->report.witness_ok);
  EXPECT_EQ(moment->report.first_bad_tick, 2550u);
  EXPECT_EQ(moment->report.what, "anchor");
  // None is kept from behind the disagreement.
  ASSERT_GT(keyframes.size(), 0u);
  EXPECT_LE(keyframes.place(keyframes.size() - 1).ticks, 2550u);
}

TEST(MomentTest, BrokenChainIsRefusedBeforeAndBehindTheKeyframe) {
  for (size_t broken : {3u, 27u}) {
    sample::Recording r = Attempt();
    Keyframes keyframes = KeyframesOf(r);
    std::swap(r.chunks[broken], r.chunks[broken + 1]);
    auto moment = Reach(r, UINT64_MAX, keyframes);
    ASSERT_FALSE(moment.ok());
    EXPECT_EQ(moment.status().code(), Code::kConflict) << moment.status().message();
  }
}

TEST(KeyframesTest, AnotherRecordingsAreRefused) {
  Bytes bytes = KeyframesOf(Attempt()).Encode();
  auto read = Keyframes::Decode(bytes, HashSha256(AsBytes("another header")));
  EXPECT_EQ(read.status().code(), Code::kConflict);
}

TEST(KeyframesTest, AnotherCoresAreRefused) {
  Bytes bytes = KeyframesOf(Attempt()).Encode();
  bytes[8] ^= 0x40;  // build, which the core version is part of
  EXPECT_EQ(Keyframes::Decode(bytes, HeaderHash(Attempt())).status().code(), Code::kVersion);
}

// Memory is bounded by the tooth's bricks, not by the file's claim: a million bricks are 1 GiB.
TEST(KeyframesTest, MoreBricksThanTheToothHasAreRefused) {
  const Bytes bytes = KeyframesOf(Attempt()).Encode();
  // Magic, reserved, build and header's hash; then kind and size of the record. In it,
  // before the count of bricks: ticks, chunks, gaps, chain, state hash.
  constexpr size_t kRecords = 6 + 2 + 8 + 32, kCount = 8 + 4 + 8 + 32 + 8;
  ByteReader first(ByteView(bytes).subspan(kRecords + 1));
  const ByteView content = first.Blob(bytes.size());
  for (uint32_t bricks : {uint32_t{1} << 20, uint32_t{1} << 16}) {
    Bytes lies(content.begin(), content.end());
    for (size_t i = 0; i < 4; ++i) lies[kCount + i] = static_cast<uint8_t>(bricks >> (8 * i));
    ByteWriter out;
    out.Raw(ByteView(bytes).first(kRecords));
    WriteRecord(1, lies, out);
    auto read = Keyframes::Decode(out.bytes(), HeaderHash(Attempt()));
    ASSERT_TRUE(read.ok()) << read.status().message();
    auto core = MakeCore();
    const Status refused = read->Restore(0, *core);
    EXPECT_EQ(refused.code(), Code::kInvalidInput);
    EXPECT_NE(refused.message().find("more bricks than the tooth"), std::string::npos)
        << refused.message();
  }
}

TEST(KeyframesTest, CutShortAnywhereGivesThoseBeforeOrARefusal) {
  sample::Recording r = sample::Record(sample::CutInputs(900), 300);
  Keyframes whole = KeyframesOf(r);
  Bytes bytes = whole.Encode();
  size_t most = 0;
  for (size_t n = 0; n < bytes.size(); n += 7) {
    auto read = Keyframes::Decode(ByteView(bytes).first(n), HeaderHash(r));
    if (!read.ok()) {
      EXPECT_LT(n, 48u);
      continue;
    }
    ASSERT_LT(read->size(), whole.size());
    ASSERT_GE(read->size(), most);
    most = read->size();
    for (size_t i = 0; i < read->size(); ++i) ASSERT_EQ(read->place(i), whole.place(i));
  }
  EXPECT_EQ(most, whole.size() - 1);
}

TEST(KeyframesTest, DamagedBytesNeverGiveAnotherTooth) {
  sample::Recording r = sample::Record(sample::CutInputs(900), 300);
  Bytes bytes = KeyframesOf(r).Encode();
  auto truth = SteppedTo(r, 850);
  for (size_t at = 0; at < bytes.size(); at += bytes.size() / 61) {
    Bytes damaged = bytes;
    damaged[at] ^= 0x21;
    auto read = Keyframes::Decode(damaged, HeaderHash(r));
    Keyframes keyframes = read.ok() ? *read : Keyframes(HeaderHash(r));
    auto moment = Reach(r, 850, keyframes);
    ASSERT_TRUE(moment.ok()) << at;
    ASSERT_EQ(moment->core->state_hash(), truth->state_hash()) << at;
    ASSERT_TRUE(moment->core->volume() == truth->volume()) << at;
  }
}

}  // namespace
}  // namespace enamel::trace
