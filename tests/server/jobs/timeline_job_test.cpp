#include "server/jobs/timeline_job.h"

#include <gtest/gtest.h>

#include "common/timeline/player.h"
#include "common/trace/replay.h"
#include "server/jobs/score_job.h"
#include "tests/server/jobs/job_school.h"

namespace enamel::server {
namespace {

using test::JobSchool;
using test::World;

class TimelineJobTest : public ::testing::Test {
 protected:
  TimelineRow TimelineOf(const Uuid& attempt) {
    const auto row = school_->store->timelines.TimelineOf(attempt);
    EXPECT_TRUE(row.ok()) << row.status().message();
    return *row;
  }
  Status Run(const Uuid& attempt, const JobProgress& progress = {}) {
    return RunTimelineJob(*school_->store, attempt, progress);
  }
  timeline::Player Opened(const Uuid& attempt) {
    const Bytes content = school_->Blob(TimelineOf(attempt).content);
    auto head = timeline::DecodeHead(content);
    EXPECT_TRUE(head.ok()) << head.status().message();
    auto player = timeline::Player::Open(school_->Blob(head->start), content);
    EXPECT_TRUE(player.ok()) << player.status().message();
    return std::move(player).value();
  }
  // The tooth after so many ticks, by a replay of its own.
  cutting::Volume ToothAfter(const Uuid& attempt, uint64_t ticks) {
    const test::Recording trace = school_->RecordingOf(attempt);
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
  std::unique_ptr<JobSchool> school_ = JobSchool::WithReference();
  // Scored, and without its timeline.
  const Uuid attempt_ = school_->reference;
};

TEST_F(TimelineJobTest, ToothAtAFrameIsTheReplaysAtItsTick) {
  ASSERT_TRUE(Run(attempt_).ok());
  timeline::Player player = Opened(attempt_);
  const timeline::Head& head = player.head();
  EXPECT_EQ(head.ticks, school_->RecordingOf(attempt_).seal.ticks);
  EXPECT_EQ(head.frame_ticks, 100u) << "a tenth of a second";
  // Every third: the tooth stays in those between.
  for (uint32_t frame : {head.frames() / 9 * 3, head.frames() / 6 * 3, head.frames()}) {
    ASSERT_TRUE(player.Seek(frame).ok());
    const cutting::Volume tooth =
        ToothAfter(attempt_, std::min<uint64_t>(head.ticks, uint64_t{frame} * 100));
    for (int b = 0; b < head.spec.brick_count(); ++b) {
      ASSERT_EQ(player.BrickSamples(b), timeline::QuantiseBrick(tooth, b))
          << "frame " << frame << ", brick " << b;
    }
  }
}

// Scored, and so verified tick by tick.
TEST_F(TimelineJobTest, AnAttemptInWhichTheBurWasChangedIsScoredAndShownWithTheBurThatCut) {
  const Uuid changed = school_->Record({.bur = 1});
  ASSERT_TRUE(RunScoreJob(*school_->store, changed).ok());
  ASSERT_TRUE(Run(changed).ok());
  timeline::Player player = Opened(changed);
  EXPECT_EQ(player.head().outlines.size(), 2u);
  const auto poses = player.Poses(0);
  ASSERT_TRUE(poses.ok()) << poses.status().message();
  EXPECT_EQ((*poses)[0].bur, 0) << "after 0.1 s";
  EXPECT_EQ((*poses)[1].bur, 1);
  EXPECT_EQ(poses->back().bur, 1);
  const auto left_m3 = [&](const Uuid& attempt) {
    const uint64_t ticks = school_->RecordingOf(attempt).seal.ticks;
    return cutting::SolidVolume_m3(
        ToothAfter(attempt, ticks))[static_cast<size_t>(cutting::Tissue::kGypsum)];
  };
  // On the same way the pear, which is wider above its ball, leaves less.
  EXPECT_LT(left_m3(changed), left_m3(attempt_) - 0.1e-9);
}

TEST_F(TimelineJobTest, RunningItAgainGivesTheSameBytes) {
  ASSERT_TRUE(Run(attempt_).ok());
  const Sha256 first = TimelineOf(attempt_).content;
  ASSERT_TRUE(Run(attempt_).ok());
  EXPECT_EQ(TimelineOf(attempt_).content, first);
}

TEST_F(TimelineJobTest, AttemptsAtOneToothShareItsStartTooth) {
  const Uuid other = school_->Record({.mesial_extra_mm = 0.2});
  ASSERT_TRUE(RunScoreJob(*school_->store, other).ok());
  ASSERT_TRUE(Run(attempt_).ok());
  ASSERT_TRUE(Run(other).ok());
  EXPECT_NE(TimelineOf(attempt_).content, TimelineOf(other).content);
  EXPECT_EQ(Opened(attempt_).head().start, Opened(other).head().start);
}

TEST_F(TimelineJobTest, ARecordingThatDisagreesHasAProblemAndNoTimeline) {
  school_->Spoil(attempt_, [&](test::Recording& recording) {
    Bytes& chunk = recording.chunks.back();
    chunk = world_.Resign(chunk, [](trace::Tick& tick) { tick.witness.anchor_100nm[0] += 1; });
  });
  ASSERT_EQ(*school_->store->timelines.TakeTimeline(), attempt_);
  ASSERT_TRUE(Run(attempt_).ok());
  EXPECT_TRUE(TimelineOf(attempt_).content.IsZero());
  EXPECT_FALSE(TimelineOf(attempt_).waits);
  EXPECT_NE(TimelineOf(attempt_).problem.find("part at tick"), std::string::npos)
      << TimelineOf(attempt_).problem;
}

TEST_F(TimelineJobTest, AFullDiskIsTriedAgain) {
  school_->disk.until_failure = 0;
  EXPECT_EQ(Run(attempt_).code(), Code::kStorage);
  EXPECT_TRUE(TimelineOf(attempt_).waits);
  EXPECT_TRUE(Run(attempt_).ok());
}

// The tooth is packed before the replay, and meshed after it. Both take seconds for a fine tooth, and a server that
// has to stop must not wait for them.
TEST_F(TimelineJobTest, StoppedOnTheWayItLeavesNothing) {
  int before = 0, after = 0;
  ASSERT_TRUE(Run(attempt_, [&](double done) {
                before += done == 0;
                after += done == 1;
                return true;
              }).ok());
  EXPECT_GT(before, 3);
  EXPECT_GT(after, 3);
  for (const double at : {0.0, 1.0}) {
    const auto school = JobSchool::WithReference();
    const Uuid attempt = school->reference;
    int asked = 0;
    const Status status = RunTimelineJob(*school->store, attempt,
                                         [&](double done) { return done != at || ++asked < 3; });
    EXPECT_EQ(status.code(), Code::kUnavailable) << at;
    EXPECT_EQ(asked, 3);
    const auto row = school->store->timelines.TimelineOf(attempt);
    ASSERT_TRUE(row.ok());
    EXPECT_TRUE(row->waits);
    EXPECT_TRUE(row->content.IsZero());
    EXPECT_EQ(row->problem, "");
  }
}

}  // namespace
}  // namespace enamel::server
