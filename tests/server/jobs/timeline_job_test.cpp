#include "server/jobs/timeline_job.h"

#include <gtest/gtest.h>

#include "common/timeline/player.h"
#include "common/trace/replay.h"
#include "tests/server/jobs/recorded_attempt.h"

namespace enamel::server {
namespace {

using test::MemoryStore;
using test::World;

class TimelineJobTest : public testing::Test {
 protected:
  TimelineJobTest() { world_.AddTo(store_); }

  timeline::Player Opened(const Uuid& attempt) {
    const Sha256 content = store_.timelines[attempt].content;
    auto head = timeline::DecodeHead(store_.blobs[content]);
    EXPECT_TRUE(head.ok()) << head.status().message();
    auto player = timeline::Player::Open(store_.blobs[head->start], store_.blobs[content]);
    EXPECT_TRUE(player.ok()) << player.status().message();
    return std::move(player).value();
  }
  // The tooth after so many ticks, by a replay of its own.
  cutting::Volume ToothAfter(const Uuid& attempt, uint64_t ticks) {
    const auto& trace = store_.traces[attempt];
    const trace::Header header = *trace::DecodeHeader(trace.header);
    core::Core core(header.params, world_.volume);
    cutting::Volume out = world_.volume;
    uint64_t done = 0;
    EXPECT_TRUE(trace::Replay(core, header, trace.chunks, [&](const auto&, const auto&) {
                  if (++done == ticks) out = core.volume();
                }).ok());
    return out;
  }

  const World& world_ = World::Get();
  MemoryStore store_;
};

TEST_F(TimelineJobTest, ToothAtAFrameIsTheReplaysAtItsTick) {
  const Uuid attempt = world_.Record(store_);
  ASSERT_TRUE(RunTimelineJob(store_, attempt).ok());
  timeline::Player player = Opened(attempt);
  const timeline::Head& head = player.head();
  EXPECT_EQ(head.ticks, store_.traces[attempt].seal.ticks);
  EXPECT_EQ(head.frame_ticks, 100u) << "a tenth of a second";
  for (uint32_t frame : {head.frames() / 3, head.frames() / 2, head.frames()}) {
    ASSERT_TRUE(player.Seek(frame).ok());
    const cutting::Volume tooth =
        ToothAfter(attempt, std::min<uint64_t>(head.ticks, uint64_t{frame} * 100));
    for (int b = 0; b < head.spec.brick_count(); ++b) {
      ASSERT_EQ(player.BrickSamples(b), timeline::QuantiseBrick(tooth, b))
          << "frame " << frame << ", brick " << b;
    }
  }
}

TEST_F(TimelineJobTest, RunningItAgainGivesTheSameBytes) {
  const Uuid attempt = world_.Record(store_);
  ASSERT_TRUE(RunTimelineJob(store_, attempt).ok());
  const Sha256 first = store_.timelines[attempt].content;
  ASSERT_TRUE(RunTimelineJob(store_, attempt).ok());
  EXPECT_EQ(store_.timelines[attempt].content, first);
}

TEST_F(TimelineJobTest, AttemptsAtOneToothShareItsStartTooth) {
  const Uuid one = world_.Record(store_), other = world_.Record(store_, {.mesial_extra_mm = 0.2});
  ASSERT_TRUE(RunTimelineJob(store_, one).ok());
  ASSERT_TRUE(RunTimelineJob(store_, other).ok());
  EXPECT_NE(store_.timelines[one].content, store_.timelines[other].content);
  EXPECT_EQ(Opened(one).head().start, Opened(other).head().start);
  EXPECT_EQ(store_.start_teeth.size(), 1u);
}

TEST_F(TimelineJobTest, ARecordingThatDisagreesHasAProblemAndNoTimeline) {
  const Uuid attempt = world_.Record(store_);
  Bytes& chunk = store_.traces[attempt].chunks.back();
  chunk = world_.Resign(chunk, [](trace::Tick& tick) { tick.witness.anchor_10nm[0] += 1; });
  ASSERT_TRUE(RunTimelineJob(store_, attempt).ok());
  EXPECT_TRUE(store_.timelines[attempt].content.IsZero());
  EXPECT_FALSE(store_.timelines[attempt].waits);
  EXPECT_NE(store_.timelines[attempt].problem.find("part at tick"), std::string::npos)
      << store_.timelines[attempt].problem;
}

TEST_F(TimelineJobTest, AFullDiskIsTriedAgain) {
  const Uuid attempt = world_.Record(store_);
  store_.failing_puts = 1;
  EXPECT_EQ(RunTimelineJob(store_, attempt).code(), Code::kStorage);
  EXPECT_TRUE(store_.timelines[attempt].waits);
  EXPECT_TRUE(RunTimelineJob(store_, attempt).ok());
}

TEST_F(TimelineJobTest, StoppedOnTheWayItLeavesNothing) {
  const Uuid attempt = world_.Record(store_);
  EXPECT_EQ(RunTimelineJob(store_, attempt, [](double) { return false; }).code(),
            Code::kUnavailable);
  EXPECT_EQ(store_.timelines.count(attempt), 0u);
}

}  // namespace
}  // namespace enamel::server
