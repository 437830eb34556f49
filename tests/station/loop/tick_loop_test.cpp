#include "station/loop/tick_loop.h"

#include <gtest/gtest.h>

#include <deque>
#include <thread>

#include "common/scene/builtin.h"
#include "common/scene/plan.h"
#include "tests/support/allocation_guard.h"

namespace enamel::station {
namespace {

// Plays what it is told and remembers the forces it was sent.
class ScriptedDevice final : public Device {
 public:
  std::string Name() const override { return "scripted"; }
  DeviceSample ReadSample() noexcept override {
    DeviceSample s = sample;
    s.counts[2] = start_z - static_cast<int32_t>(reads++) * step;
    if (finish_after != 0 && reads >= finish_after) s.buttons |= kFinish;
    return s;
  }
  void SendForce(const dvec3& force_n) noexcept override {
    last_force = force_n;
    ++sends;
  }

  DeviceSample sample;
  int32_t start_z = 0, step = 0;
  uint64_t reads = 0, finish_after = 0, sends = 0;
  dvec3 last_force{0};
};

class TickLoopTest : public testing::Test {
 protected:
  TickLoopTest() {
    auto built = scene::BuildBuiltinScene("block", 200'000);
    EXPECT_TRUE(built.ok());
    auto params = scene::CompilePlan(built->scene, scene::ClassOneExercise(built->scene, {}),
                                     scene::BuiltinProfiles()[1]);
    EXPECT_TRUE(params.ok()) << params.status().message();
    params_ = *params;
    params_.soft_start_ticks = 1;
    volume_ = std::move(built->volume);
    // From 0.3 mm above the block down into it, one count per tick.
    int64_t top_nm = built->scene.landmarks.at("occlusal_centre")[2] * int64_t{1000};
    int64_t start = (top_nm + 300'000 - params_.device_origin_nm[2]) / params_.resolution_nm[2];
    device_.start_z = static_cast<int32_t>(start);
    device_.step = 1;
    device_.sample.buttons = kPedal;
  }

  core::CoreParams params_;
  cutting::Volume volume_;
  ScriptedDevice device_;
};

TEST_F(TickLoopTest, RecordsEachSteppedTickWithTheForceThatWasSent) {
  core::Core core(params_, volume_);
  SampleRing ring(100);
  TickLoop loop(device_, core, ring, {1000, true, true});
  bool cut = false;
  for (int i = 0; i < 100; ++i) {
    loop.Tick();
    Sample s;
    ASSERT_TRUE(ring.Pop(s));
    EXPECT_EQ(s.state_hash, core.state_hash());
    EXPECT_NEAR(s.tick.witness.force_sent_100un[2] * 1e-4, device_.last_force.z, 0.51e-4);
    cut = cut || device_.last_force.z > 0;
  }
  EXPECT_TRUE(cut);
  EXPECT_EQ(loop.snapshot().counters.ticks, 100u);
}

TEST_F(TickLoopTest, TickThatCannotBeRecordedIsNotSteppedAndDeclaredAsGap) {
  core::Core core(params_, volume_);
  SampleRing ring(60);
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 60; ++i) loop.Tick();
  uint64_t hash = core.state_hash();
  for (int i = 0; i < 7; ++i) loop.Tick();
  EXPECT_EQ(core.state_hash(), hash);
  EXPECT_EQ(device_.last_force, dvec3(0));
  Sample s;
  while (ring.Pop(s)) EXPECT_EQ(s.tick.input.gap_ticks, 0u);
  loop.Tick();
  ASSERT_TRUE(ring.Pop(s));
  EXPECT_EQ(s.tick.input.gap_ticks, 7u);
  EXPECT_EQ(loop.snapshot().counters.gap_ticks, 7u);
}

TEST_F(TickLoopTest, WhatIsRecordedReplaysToTheSameStateAlsoAfterGaps) {
  core::Core core(params_, volume_);
  SampleRing ring(40);
  TickLoop loop(device_, core, ring, {1000, false, true});
  std::vector<Sample> recorded;
  Sample s;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 40 + 3 * round; ++i) loop.Tick();
    while (ring.Pop(s)) recorded.push_back(s);
  }
  core::Core again(params_, volume_);
  for (const Sample& r : recorded) {
    EXPECT_EQ(again.Step(r.tick.input).witness, r.tick.witness);
    ASSERT_EQ(again.state_hash(), r.state_hash);
  }
}

TEST_F(TickLoopTest, AllocatesNothingInATick) {
  core::Core core(params_, volume_);
  SampleRing ring(1000);
  TickLoop loop(device_, core, ring, {1000, true, true});
  loop.Tick();
  size_t allocations = 0;
  {
    testing_support::AllocationGuard guard;
    for (int i = 0; i < 500; ++i) loop.Tick();
    allocations = guard.count();
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_GT(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)], 0);
}

TEST_F(TickLoopTest, AllocationGuardSeesAllocations) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "skipped: ThreadSanitizer brings its own operator new";
#endif
  testing_support::AllocationGuard guard;
  delete new int(1);
  EXPECT_EQ(guard.count(), 1u);
}

TEST_F(TickLoopTest, TickFiveMillisecondsLateFaultsUntilThePedalIsPressedAgain) {
  core::Core core(params_, volume_);
  SampleRing ring(1000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  auto flags = [&](double late_s) {
    loop.Tick(late_s);
    Sample s;
    EXPECT_TRUE(ring.Pop(s));
    return s.tick.input.flags;
  };
  EXPECT_EQ(flags(0), core::kBurOn);
  EXPECT_EQ(flags(0.0012), core::kBurOn | core::kLateTick);
  EXPECT_TRUE(flags(0.006) & core::kFaulted);
  EXPECT_EQ(device_.last_force, dvec3(0));
  EXPECT_TRUE(flags(0) & core::kFaulted);  // the pedal is still down
  device_.sample.buttons = 0;
  EXPECT_TRUE(flags(0) & core::kFaulted);
  device_.sample.buttons = kPedal;
  EXPECT_EQ(flags(0), core::kBurOn | core::kSoftRestart);
  EXPECT_EQ(flags(0), core::kBurOn);
  EXPECT_EQ(loop.snapshot().counters.faults, 1u);
}

TEST_F(TickLoopTest, ManyLateTicksInASecondFault) {
  core::Core core(params_, volume_);
  SampleRing ring(1000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  for (int i = 0; i < 20; ++i) loop.Tick(0.002);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  loop.Tick(0.002);
  EXPECT_EQ(loop.fault(), Fault::kLateOften);
}

TEST_F(TickLoopTest, DeviceThatSaysNothingNewForFiveMillisecondsFaults) {
  core::Core core(params_, volume_);
  SampleRing ring(1000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.sample.fresh = false;
  for (int i = 0; i < 4; ++i) loop.Tick();
  EXPECT_EQ(loop.fault(), Fault::kNone);
  for (int i = 0; i < 2; ++i) loop.Tick();
  EXPECT_EQ(loop.fault(), Fault::kStalled);
}

TEST_F(TickLoopTest, LockstepWaitsForASlowRecorderInsteadOfDropping) {
  core::Core core(params_, volume_);
  SampleRing ring(4);
  device_.step = 0;
  device_.finish_after = 300;
  TickLoop loop(device_, core, ring, {1000, true, false});
  std::thread ticks([&] { loop.Run(); });
  uint64_t popped = 0;
  Sample s;
  while (true) {
    bool ended = loop.finished();
    bool any = false;
    while (ring.Pop(s)) {
      ++popped;
      any = true;
      EXPECT_EQ(s.tick.input.gap_ticks, 0u);
    }
    if (ended && !any) break;
    std::this_thread::yield();
  }
  ticks.join();
  EXPECT_EQ(popped, 300u);
  EXPECT_EQ(device_.last_force, dvec3(0));
}

}  // namespace
}  // namespace enamel::station
