#include "common/trace/replay.h"

#include <gtest/gtest.h>

#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

// A recording in which `change` altered one tick before it was encoded, chained and signed again:
// what a station with a wrong core, or a forger with its key, would send.
sample::Recording Altered(size_t tick, void (*change)(Tick&)) {
  auto recording = sample::Record(sample::CutInputs(1200), 300);
  change(recording.ticks[tick]);
  std::vector<Bytes> chunks;
  Sha256 previous = HashSha256(EncodeHeader(recording.header));
  for (size_t c = 0; c < recording.chunks.size(); ++c) {
    ChunkHead head = DecodeChunkHead(recording.chunks[c])->head;
    head.previous = previous;
    std::span<const Tick> ticks(recording.ticks);
    chunks.push_back(
        EncodeChunk(head, ticks.subspan(c * 300, 300), sample::StationKeys().secret_key));
    previous = DecodeChunkHead(chunks.back())->hash;
  }
  recording.chunks = std::move(chunks);
  return recording;
}

Result<ReplayReport> RunReplay(const sample::Recording& recording) {
  core::Core core(recording.header.params, sample::MakeBlock());
  return Replay(core, recording.header, recording.chunks);
}

TEST(ReplayTest, RecomputesEveryTickOfARecording) {
  auto recording = sample::Record(sample::CutInputs(6000), 500);
  core::Core core(recording.header.params, sample::MakeBlock());
  size_t seen = 0;
  int64_t removed = 0;
  auto report = Replay(core, recording.header, recording.chunks,
                       [&](const Tick& tick, const core::TickOutput& out) {
                         EXPECT_EQ(tick, recording.ticks[seen]);
                         ++seen;
                         for (int64_t units : out.removed) removed += units;
                       });
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(report->witness_ok) << report->what << " at " << report->first_bad_tick;
  EXPECT_EQ(report->ticks, 6000u);
  EXPECT_EQ(seen, 6000u);
  EXPECT_EQ(report->chunks, 12u);
  EXPECT_EQ(report->state_hash, recording.seal.state_hash);
  EXPECT_GT(removed, 0);
}

struct Alteration {
  const char* what;
  void (*change)(Tick&);
};
class ReplayDivergenceTest : public testing::TestWithParam<Alteration> {};

TEST_P(ReplayDivergenceTest, IsPlacedToTickAndField) {
  auto report = RunReplay(Altered(777, GetParam().change));
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(report->witness_ok);
  EXPECT_EQ(report->first_bad_tick, 777u);
  EXPECT_EQ(report->first_bad_chunk, 2u);
  EXPECT_EQ(report->what, GetParam().what);
  EXPECT_EQ(report->ticks, 1200u);
}

constexpr Alteration kAlterations[] = {
    {"force_sent", [](Tick& tick) { tick.witness.force_sent_mn[1] += 1; }},
    {"force_computed", [](Tick& tick) { tick.witness.force_computed_mn[2] -= 1; }},
    {"anchor", [](Tick& tick) { tick.witness.anchor_100nm[0] += 1; }},
    {"flags", [](Tick& tick) { tick.witness.flags ^= 1; }},
    // Another input moves the force at the same tick.
    {"force_sent", [](Tick& tick) { tick.input.counts[2] -= 40; }},
};
INSTANTIATE_TEST_SUITE_P(Fields, ReplayDivergenceTest, testing::ValuesIn(kAlterations),
                         [](const auto& alteration) {
                           return std::string(alteration.param.what) + "_" +
                                  std::to_string(alteration.index);
                         });

TEST(ReplayTest, WrongStateHashIsPlacedAtTheEndOfItsChunk) {
  auto recording = sample::Record(sample::CutInputs(600), 600);
  ChunkHead head = DecodeChunkHead(recording.chunks[0])->head;
  head.state_hash ^= 1;
  recording.chunks[0] = EncodeChunk(head, recording.ticks, sample::StationKeys().secret_key);
  auto report = RunReplay(recording);
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->witness_ok);
  EXPECT_EQ(report->what, "state_hash");
  EXPECT_EQ(report->first_bad_tick, 599u);
}

TEST(ReplayTest, CountsDeclaredGaps) {
  auto inputs = sample::CutInputs(900);
  inputs[400].gap_ticks = 25;
  inputs[401].gap_ticks = 5;
  auto report = RunReplay(sample::Record(inputs, 300));
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->witness_ok);
  EXPECT_EQ(report->gap_ticks, 30u);
}

TEST(ReplayTest, ExchangedChunksAreAnError) {
  auto recording = sample::Record(sample::CutInputs(600), 300);
  std::swap(recording.chunks[0], recording.chunks[1]);
  EXPECT_EQ(RunReplay(recording).status().code(), Code::kConflict);
}

TEST(ReplayTest, UndecodableChunkIsNamed) {
  auto recording = sample::Record(sample::CutInputs(600), 300);
  recording.chunks[1].resize(50);
  auto report = RunReplay(recording);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.status().message().rfind("chunk 1:", 0), 0u) << report.status().message();
}

TEST(ReplayTest, CoreWithOtherParametersOrAlreadySteppedIsRefused) {
  auto recording = sample::Record(sample::CutInputs(300), 300);
  core::CoreParams params = recording.header.params;
  params.peak_force_mn += 1;
  core::Core other(params, sample::MakeBlock());
  EXPECT_FALSE(Replay(other, recording.header, recording.chunks).ok());
  core::Core stepped(recording.header.params, sample::MakeBlock());
  stepped.Step({});
  EXPECT_FALSE(Replay(stepped, recording.header, recording.chunks).ok());
}

TEST(ReplayTest, RecomputesARecordingInWhichTheBurWasChanged) {
  auto inputs = sample::CutInputs(3000);
  for (size_t i = 200; i < inputs.size(); ++i) inputs[i].flags |= core::BurFlags(1);
  const auto recording = sample::Record(inputs, 500),
             first = sample::Record(sample::CutInputs(3000), 500);
  auto report = RunReplay(recording);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(report->witness_ok) << report->what << " at " << report->first_bad_tick;
  EXPECT_EQ(report->state_hash, recording.seal.state_hash);
  EXPECT_NE(report->state_hash, first.seal.state_hash);
}

TEST(ReplayTest, ATickWithABurThatTheHeaderDoesNotHaveIsRefused) {
  const auto report = RunReplay(Altered(700, [](Tick& t) { t.input.flags |= core::BurFlags(2); }));
  EXPECT_EQ(report.status().code(), Code::kInvalidInput);
  EXPECT_EQ(report.status().field(), "input flags");
  EXPECT_NE(report.status().message().find("tick 700 names bur 2"), std::string::npos)
      << report.status().message();
}

// Hours of nonsense cost a chunk.
TEST(ReplayTest, EndsWithTheChunkOfTheFirstDifferenceWhenNothingElseIsWanted) {
  const auto recording = Altered(310, [](Tick& tick) { tick.witness.anchor_100nm[0] += 1; });
  core::Core core(recording.header.params, sample::MakeBlock());
  const auto report = Replay(core, recording.header, EachOf(recording.chunks),
                             recording.chunks.size(), {}, {}, AfterDifference::kStop);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_FALSE(report->witness_ok);
  EXPECT_EQ(report->first_bad_tick, 310u);
  EXPECT_EQ(report->ticks, 600u) << "of 1200";
}

TEST(ReplayTest, StopsWhenAsked) {
  auto recording = sample::Record(sample::CutInputs(600), 100);
  core::Core core(recording.header.params, sample::MakeBlock());
  double last = -1;
  auto report = Replay(core, recording.header, recording.chunks, {}, [&](double progress) {
    last = progress;
    return progress < 0.5;
  });
  EXPECT_EQ(report.status().code(), Code::kUnavailable);
  EXPECT_DOUBLE_EQ(last, 0.5);
  EXPECT_EQ(core.ticks(), 300u);
}

}  // namespace
}  // namespace enamel::trace
