#include "station/loop/tick_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <random>
#include <thread>

#include "station/devices/simulated_device.h"
#include "tests/common/core/params.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/analytic_volume.h"
#include "tests/support/block_plan.h"

namespace enamel::station {
namespace {

// Plays scripted samples and remembers the forces it was sent.
class ScriptedDevice final : public Device {
 public:
  std::string Name() const override { return "scripted"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
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
  void SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept override {
    SendForce(force_n);
    last_torque = torque_n_m;
  }
  double still_before_force_s() const noexcept override { return still_s; }

  DeviceSample sample;
  double still_s = 0;
  int32_t start_z = 0, step = 0;
  uint64_t reads = 0, finish_after = 0, sends = 0;
  dvec3 last_force{0}, last_torque{0};
};

class TickLoopTest : public testing::Test {
 protected:
  TickLoopTest() {
    test::BlockPlan block = test::MakeBlockPlan();
    params_ = block.params;
    volume_ = std::move(block.volume);
    // From 0.3 mm above the block down into it, one count per tick.
    device_.start_z = block.CountsAbove(300'000);
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
    EXPECT_NEAR(s.tick.witness.force_sent_mn[2] * 1e-3, device_.last_force.z, 0.51e-3);
    cut = cut || device_.last_force.z > 0;
  }
  EXPECT_TRUE(cut);
  EXPECT_EQ(loop.snapshot().counters.ticks, 100u);
}

// A six-axis device twists the bur in the block: torque with the force, and no torque without
// force.
TEST_F(TickLoopTest, TorqueIsSentWithTheForceAndIsZeroWithIt) {
  params_.rotational_kc_un_m_per_rad = 800'000;
  params_.peak_torque_un_m = 200'000;
  params_.rotation_cell_urad = 300;
  core::Core core(params_, volume_);
  SampleRing ring(2000);
  TickLoopOptions options{1000, false, true};
  TickLoop loop(device_, core, ring, options);
  bool pushed = false;
  for (int i = 0; i < 1200; ++i) {
    if (i == 150) device_.step = 0, device_.start_z -= 150;
    loop.Tick();
    pushed = pushed || device_.last_force.z > 0;
  }
  EXPECT_TRUE(pushed);
  device_.sample.buttons = 0;  // a still bur in its hole
  for (int16_t i = 0; i < 100; ++i) {
    device_.sample.orientation = {static_cast<int16_t>(20 * i), 0, 0, 32700};
    loop.Tick();
  }
  EXPECT_LT(device_.last_torque.x, -0.01);
  // A gap: neither.
  loop.Hold(true);
  loop.Tick();
  EXPECT_EQ(device_.last_torque, dvec3(0));
  loop.Hold(false);
  device_.sample.orientation = kIdentityOrientation;
  for (int i = 0; i < 20; ++i) loop.Tick();
  for (int16_t i = 0; i < 100; ++i) {
    device_.sample.orientation = {static_cast<int16_t>(20 * i), 0, 0, 32700};
    loop.Tick();
  }
  EXPECT_LT(device_.last_torque.x, -0.01);
  // A late tick leaks by turning too: here K/2 |dphi|^2, only the angle changes.
  const double before = loop.counters().leak_j;
  device_.sample.orientation = {2200, 0, 0, 32700};
  loop.Tick(0.0015);
  EXPECT_NEAR(loop.counters().leak_j - before, 0.4 * std::pow(2 * 220.0 / 32767, 2), 0.4e-5);
  // A fault: neither.
  device_.sample.attached = false;
  loop.Tick();
  EXPECT_EQ(loop.fault(), Fault::kUnplugged);
  EXPECT_EQ(device_.last_torque, dvec3(0));
  EXPECT_EQ(device_.last_force, dvec3(0));
}

// Cuts 2 mm into a block, lets the bur stand and tilts the handpiece by 0.1 rad.
class TwistingHand final : public SimulatedOperator {
 public:
  static constexpr int kCut = 4500, kTilt = 4600, kEnd = 5200;
  std::string Name() const override { return "twisting"; }
  dvec3 Start_m() const override { return dvec3(0, 0, 0.5e-3); }
  HandDrive Act(const dvec3&, const dvec3&, double) noexcept override {
    HandDrive hand;
    hand.equilibrium_m = dvec3(0, 0, std::fmax(-2e-3, 0.5e-3 - std::fmax(0, tick_ - 50) * 1e-6));
    hand.stiffness_n_per_m = 2000;
    hand.damping_n_s_per_m = 5;
    hand.max_force_n = 20;
    hand.pedal = tick_ < kCut;
    const double tilt = 0.1 * std::fmin(1, std::fmax(0, tick_ - kTilt) / 100.0);
    hand.orientation = Quat{std::sin(tilt / 2), 0, 0, std::cos(tilt / 2)};
    ++tick_;
    return hand;
  }
  double Progress() const noexcept override { return 0; }

 private:
  int tick_ = 0;
};

// The whole chain: hand, device, core and motors. The wall holds the bur, so two springs share the
// tilt: the hand's 1 N m/rad and the torque's 0.8 leave the device at 1/1.8 of it. Without torque
// it is at the hand's angle.
TEST(TorqueLoopTest, ATwistedHandpieceInItsHoleIsHeldByTheTorquesSpring) {
  for (bool torque : {true, false}) {
    core::CoreParams params = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
    params.soft_start_ticks = 5;
    params.rotational_kc_un_m_per_rad = 800'000;
    params.peak_torque_un_m = torque ? 200'000 : 0;
    params.rotation_cell_urad = torque ? 300 : 0;
    core::Core core(params, test::Block(50'000, 2e-3, 4e-3));
    PlantParams plant;
    plant.mass_kg = 0.2;
    plant.damping_n_s_per_m = 2;
    plant.friction_n = 0.02;
    plant.resolution_m = 10e-6;
    plant.peak_force_n = 7.9;
    plant.inertia_kg_m2 = 1e-4;
    plant.rotational_damping_n_m_s = 0.5e-3;
    plant.rotational_friction_n_m = 0.24e-3;
    plant.orientation_cell_rad = 300e-6;
    plant.peak_torque_n_m = 0.2;
    SimulatedDevice device(plant, std::make_unique<TwistingHand>());
    SampleRing ring(10);
    TickLoop loop(device, core, ring, {1000, true, false});
    Sample s;
    for (int i = 0; i < TwistingHand::kEnd; ++i) {
      loop.Tick();
      ASSERT_TRUE(ring.Pop(s));
    }
    EXPECT_LT(loop.snapshot().anchor.tip_m.z, -1.2e-3);
    EXPECT_NEAR(2 * device.orientation().x, torque ? 0.1 / 1.8 : 0.1, 0.004);
  }
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
  ::operator delete(::operator new(1));  // a new-expression may be left out by the compiler
  EXPECT_EQ(guard.count(), 1u);
}

// --- interruptions ---

// Into the block with the pedal down, until it pushes back.
class InterruptedTest : public TickLoopTest {
 protected:
  void Touch(TickLoop& loop) {
    for (int i = 0; i < 400 && device_.last_force.z < 0.2; ++i) loop.Tick();
    ASSERT_GE(device_.last_force.z, 0.2);
    Stay();
  }
  // Where it is.
  void Stay() {
    device_.start_z -= static_cast<int32_t>(device_.reads) * device_.step;
    device_.step = 0;
  }
  void GoDown() {
    device_.reads = 0;
    device_.step = 1;
  }
  void LiftOut(TickLoop& loop, int ticks) {
    device_.start_z = test::MakeBlockPlan().CountsAbove(300'000);
    device_.reads = 0;
    for (int i = 0; i < ticks; ++i) loop.Tick();
  }
};

// The tip has not moved: what was stretched is gone, and what the hand does next is felt at once.
TEST_F(InterruptedTest, ASingleShortOneIsRiddenOutInTheTooth) {
  for (bool late : {false, true}) {
    SCOPED_TRACE(late ? "a late tick" : "a silent device");
    for (uint32_t delay : {0u, 2u}) {
      SCOPED_TRACE(delay);
      device_ = ScriptedDevice();
      device_.sample.buttons = kPedal;
      device_.start_z = test::MakeBlockPlan().CountsAbove(300'000);
      device_.step = 1;
      core::CoreParams params = params_;
      params.bus_delay_ticks = delay;
      core::Core core(params, volume_);
      SampleRing ring(4000);
      TickLoop loop(device_, core, ring, {1000, false, true});
      Touch(loop);
      Sample s;
      while (ring.Pop(s)) {
      }
      if (late) {
        loop.Tick(0.0082);
        EXPECT_EQ(device_.last_force, dvec3(0));
      } else {
        device_.sample.fresh = false;
        for (int i = 0; i < 40; ++i) loop.Tick();
        EXPECT_EQ(device_.last_force, dvec3(0));
        device_.sample.fresh = true;
      }
      EXPECT_EQ(loop.fault(), Fault::kNone);
      GoDown();
      for (int i = 0; i < 100; ++i) loop.Tick();
      EXPECT_GT(device_.last_force.z, 0.1) << "still in the tooth";
      uint64_t gaps = 0;
      while (ring.Pop(s)) {
        gaps += s.tick.input.gap_ticks;
        EXPECT_FALSE(s.tick.input.flags & (core::kFaulted | core::kSoftRestart));
        if (s.tick.input.gap_ticks > 0) EXPECT_FALSE(s.tick.input.flags & core::kHeldGap);
      }
      // Declared as it passed: the ticks of silence from the fifth on; those that were late, and those
      // until the forces under way have ended.
      EXPECT_EQ(gaps, late ? 8 + delay + 1 : 36);
      EXPECT_EQ(loop.counters().interruptions, 1u);
      EXPECT_EQ(loop.counters().faults, 0u);
      EXPECT_EQ(loop.counters().passed_ticks(), loop.counters().ticks + gaps);
    }
  }
}

TEST_F(InterruptedTest, OneThatIsLongOrComesAgainWithinASecondIsAFault) {
  core::Core core(params_, volume_);
  SampleRing ring(8000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  const auto silent = [&](int ticks) {
    device_.sample.fresh = false;
    for (int i = 0; i < ticks; ++i) loop.Tick();
    device_.sample.fresh = true;
  };
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) loop.Tick();
  };
  run(10);
  silent(104);  // of which 100 without force
  EXPECT_EQ(loop.fault(), Fault::kNone);
  run(1100);
  silent(106);
  EXPECT_EQ(loop.fault(), Fault::kStalled);
  run(300);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  run(1100);
  loop.Tick(0.006);
  run(500);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  loop.Tick(0.006);
  EXPECT_EQ(loop.fault(), Fault::kLateOnce);
  run(2000);
  loop.Tick(0.12);
  EXPECT_EQ(loop.fault(), Fault::kLateOnce) << "longer than is ridden out";
  EXPECT_EQ(loop.counters().interruptions, 2u);
  EXPECT_EQ(loop.counters().faults, 3u);
}

// Whatever the pedal does: force and cut come back in free air, and there by themselves.
TEST_F(InterruptedTest, AFaultEndsByItselfAndForceReturnsInFreeAirAlone) {
  for (bool held : {true, false}) {
    device_ = ScriptedDevice();
    device_.sample.buttons = kPedal;
    device_.start_z = test::MakeBlockPlan().CountsAbove(300'000);
    device_.step = 1;
    core::Core core(params_, volume_);
    SampleRing ring(8000);
    TickLoop loop(device_, core, ring, {1000, false, true});
    Touch(loop);
    device_.sample.attached = device_.sample.fresh = false;
    loop.Tick();
    EXPECT_EQ(device_.last_force, dvec3(0));
    EXPECT_EQ(loop.fault(), Fault::kUnplugged);
    for (int i = 0; i < 500; ++i) loop.Tick();
    EXPECT_EQ(loop.fault(), Fault::kUnplugged);
    device_.sample.attached = device_.sample.fresh = true;
    if (!held) device_.sample.buttons = 0;
    // A quarter of a second alive, and no sooner.
    for (int i = 0; i < 240; ++i) loop.Tick();
    EXPECT_EQ(loop.fault(), Fault::kUnplugged);
    for (int i = 0; i < 20; ++i) loop.Tick();
    EXPECT_EQ(loop.fault(), Fault::kNone);
    const auto removed = core.removed();
    GoDown();
    for (int i = 0; i < 100; ++i) {
      loop.Tick();
      ASSERT_EQ(device_.last_force, dvec3(0)) << "still in the tooth";
    }
    EXPECT_EQ(core.removed(), removed);
    Stay();
    LiftOut(loop, 50);
    device_.sample.buttons = kPedal;
    GoDown();
    for (int i = 0; i < 400 && device_.last_force.z < 0.2; ++i) loop.Tick();
    EXPECT_GE(device_.last_force.z, 0.2);
  }
}

TEST_F(InterruptedTest, TheFaultShownIsThePresentOne) {
  core::Core core(params_, volume_);
  SampleRing ring(8000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  const auto shows = [&](bool attached, bool driven, int ticks) {
    device_.sample.attached = attached;
    device_.sample.driven = driven;
    for (int i = 0; i < ticks; ++i) loop.Tick();
    return loop.fault();
  };
  device_.sample.fresh = false;
  EXPECT_EQ(shows(true, true, 120), Fault::kStalled);
  EXPECT_EQ(shows(false, true, 1), Fault::kUnplugged);
  EXPECT_EQ(shows(true, true, 10), Fault::kStalled) << "back, and silent";
  EXPECT_EQ(shows(true, false, 1), Fault::kSwitchedOff);
  device_.sample.fresh = true;
  EXPECT_EQ(shows(true, false, 500), Fault::kSwitchedOff);
  EXPECT_EQ(shows(true, true, 300), Fault::kNone);
  EXPECT_EQ(loop.counters().faults, 1u) << "one fault, however its cause changed";
}

// An adversary: it presses, goes deeper while there is no force, and takes what it can on the way out.
TEST_F(InterruptedTest, AHandThatGoesDeeperDuringOneGainsNothing) {
  std::mt19937 random(59);
  for (int run = 0; run < 40; ++run) {
    device_ = ScriptedDevice();
    device_.sample.buttons = 0;  // a bur at rest: the tooth is a wall, which stores most
    core::Core core(params_, volume_);
    SampleRing ring(8);
    TickLoop loop(device_, core, ring, {1000, false, true});
    const int32_t above = test::MakeBlockPlan().CountsAbove(300'000);
    int32_t z = above;
    double work_j = 0, least_j = 0;
    const auto go = [&](int32_t by) {
      z += by;
      // The force of the last tick is held while the tip moves.
      work_j -= device_.last_force.z * by * params_.resolution_nm[2] * 1e-9;
      least_j = std::min(least_j, work_j + loop.counters().leak_j);
      device_.reads = 0;
      if (device_.sample.fresh) device_.start_z = z;
      loop.Tick();
      for (Sample s; ring.Pop(s);) {
      }
    };
    for (int i = 0; i < 70; ++i) go(-1);
    const int silent = 6 + static_cast<int>(random() % 80);
    device_.sample.fresh = false;
    for (int i = 0; i < silent; ++i) go(i % 4 == 0 ? -1 : 0);
    device_.sample.fresh = true;
    while (z < above) go(1);
    EXPECT_EQ(loop.counters().interruptions, 1u);
    EXPECT_EQ(loop.fault(), Fault::kNone);
    const double cell_m = core::TipCellOf(params_).Radius();
    EXPECT_GE(least_j, -0.5 * params_.kc_mn_per_mm * cell_m * cell_m - 1e-12) << run;
  }
}

// It reports every fourth tick and moves quickly in the tooth: each hold leaks.
TEST_F(InterruptedTest, ADeviceThatReportsTooSeldomForItsStiffnessIsStopped) {
  for (const double damping : {0.0, 1e6}) {
    core::Core core(params_, volume_);
    SampleRing ring(4000);
    TickLoop loop(device_, core, ring, {1000, false, true, damping});
    device_.step = 0;
    int ticks = 0;
    for (; ticks < 1000 && loop.fault() == Fault::kNone; ++ticks) {
      device_.sample.fresh = ticks % 4 == 0;
      if (device_.sample.fresh) device_.sample.counts[0] = (ticks / 4) % 2 * 10;
      loop.Tick();
    }
    if (damping == 0) {
      EXPECT_EQ(loop.fault(), Fault::kTooSlow);
      EXPECT_LE(ticks, 4 * (TickLoop::kLateTicksPerSecond + 3));
    } else {
      EXPECT_EQ(loop.fault(), Fault::kNone) << "damping pays for such holds";
    }
  }
}

// A person looks from another side while the bur rests on the tooth.
TEST_F(TickLoopTest, AxesThatTurnEndTheForceUntilTheBurHasBeenInFreeAir) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.sample.buttons = 0;
  device_.step = 1;
  while (device_.last_force == dvec3(0) && loop.counters().ticks < 3000) loop.Tick();
  ASSERT_NE(device_.last_force, dvec3(0));
  device_.start_z -= static_cast<int32_t>(device_.reads) * device_.step;  // it stays in the tooth
  device_.step = 0;
  device_.sample.counts[0] = 20;
  device_.sample.turned = true;
  loop.Tick(0.0012);
  device_.sample.turned = false;
  EXPECT_EQ(device_.last_force, dvec3(0));
  EXPECT_EQ(loop.counters().leak_j, 0) << "the jump is nobody's way";
  Sample s;
  while (ring.Pop(s)) {
  }
  EXPECT_TRUE(s.tick.input.flags & core::kSoftRestart);
  for (int i = 0; i < 1000; ++i) loop.Tick();
  EXPECT_EQ(device_.last_force, dvec3(0)) << "still in the tooth";
  while (ring.Pop(s)) {
  }
  EXPECT_FALSE(s.tick.input.flags & core::kSoftRestart);
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

TEST_F(TickLoopTest, DeviceThatSaysNothingNewForFiveMillisecondsHasNoForce) {
  core::Core core(params_, volume_);
  SampleRing ring(1000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 400 && device_.last_force.z < 0.2; ++i) loop.Tick();
  device_.sample.fresh = false;
  device_.start_z -= static_cast<int32_t>(device_.reads) * device_.step;
  device_.step = 0;
  for (int i = 0; i < 4; ++i) loop.Tick();
  EXPECT_GT(device_.last_force.z, 0);
  for (int i = 0; i < 2; ++i) loop.Tick();
  EXPECT_EQ(device_.last_force, dvec3(0));
}

TEST_F(TickLoopTest, TwentyLateTicksSpreadOverMoreThanASecondDoNotFault) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  for (int i = 0; i < 60; ++i) {
    loop.Tick(0.0015);
    for (int k = 0; k < 52; ++k) loop.Tick();  // 18.5 late ones in a second
  }
  EXPECT_EQ(loop.fault(), Fault::kNone);
  EXPECT_EQ(loop.snapshot().counters.late_ticks, 60u);
  EXPECT_EQ(loop.snapshot().counters.skipped_ticks, 60u);
}

TEST_F(TickLoopTest, ManyLateTicksFaultAlsoAcrossTheTurnOfASecond) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  for (int i = 0; i < 960; ++i) loop.Tick();
  for (int i = 0; i < 20; ++i) loop.Tick(0.001);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  loop.Tick(0.001);
  EXPECT_EQ(loop.fault(), Fault::kLateOften);
}

TEST_F(TickLoopTest, UnpluggedMidCutCommandsZeroInTheTickThatSeesIt) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 200 && device_.last_force.z < 0.2; ++i) loop.Tick();
  ASSERT_GE(device_.last_force.z, 0.2);
  auto removed = core.removed();
  device_.sample.attached = device_.sample.fresh = false;
  device_.step = 0;
  loop.Tick();
  EXPECT_EQ(device_.last_force, dvec3(0));
  EXPECT_EQ(loop.fault(), Fault::kUnplugged);
  for (int i = 0; i < 20; ++i) loop.Tick();
  EXPECT_EQ(device_.last_force, dvec3(0));
  // Tissue that the bur had passed but not yet cut is cut, within a voxel; nothing afterwards.
  EXPECT_LE(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)] -
                removed[static_cast<size_t>(cutting::Tissue::kGypsum)],
            65536 * 200);
}

TEST_F(TickLoopTest, StalledDeviceHasZeroForceTwentyMillisecondsAfterItsLastSample) {
  for (uint32_t rate : {500u, 1000u, 4000u, 8000u}) {
    core::CoreParams params = params_;
    params.rate_hz = rate;
    ScriptedDevice device;
    device.start_z = device_.start_z;
    device.step = 1;
    device.sample.buttons = kPedal;
    core::Core core(params, volume_);
    SampleRing ring(8000);
    TickLoop loop(device, core, ring, {rate, false, true});
    for (int i = 0; i < 400 && device.last_force.z < 0.2; ++i) loop.Tick();
    ASSERT_GE(device.last_force.z, 0.2) << rate;
    device.sample.fresh = false;
    device.start_z -= static_cast<int32_t>(device.reads);
    device.step = 0;
    for (uint32_t i = 0; i < rate / 50; ++i) loop.Tick();  // 20 ms
    EXPECT_EQ(device.last_force, dvec3(0)) << rate;
    for (uint32_t i = 0; i < rate / 10; ++i) loop.Tick();
    EXPECT_EQ(loop.fault(), Fault::kStalled) << rate;
    EXPECT_EQ(device.last_force, dvec3(0)) << rate;
  }
}

TEST_F(TickLoopTest, FaultKeepsTheTicksThatLedToIt) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  std::vector<core::TickInput> inputs;
  auto tick = [&](double late_s) {
    loop.Tick(late_s);
    Sample s;
    ASSERT_TRUE(ring.Pop(s));
    inputs.push_back(s.tick.input);
  };
  for (int i = 0; i < 100; ++i) tick(0);
  tick(0.107);
  ASSERT_EQ(loop.fault_records().size(), 1u);
  const FaultRecord& record = loop.fault_records()[0];
  EXPECT_EQ(record.fault, Fault::kLateOnce);
  EXPECT_EQ(record.tick, 100u);
  ASSERT_EQ(record.count, FaultRecord::kTicks);
  for (size_t i = 0; i < record.count; ++i) {
    EXPECT_EQ(record.ticks[i].input, inputs[inputs.size() - record.count + i]);
  }
  EXPECT_EQ(record.ticks.back().late_s, 0.107);
  EXPECT_EQ(record.ticks.back().force_sent_n, dvec3(0));
  EXPECT_NE(std::string(FaultText(record.fault)), "");
}

TEST_F(TickLoopTest, LeakOfAHeldForceIsItsBound) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  double b = 0.5;
  TickLoop loop(device_, core, ring, {1000, false, true, b});
  for (int i = 0; i < 10; ++i) loop.Tick();
  EXPECT_EQ(loop.snapshot().counters.leak_j, 0);
  device_.step = 0;
  device_.start_z -= 10 + 7;  // seven counts beyond the last
  loop.Tick(0.002);
  double dx = (7 + 1) * params_.resolution_nm[2] * 1e-9;
  double kc = params_.kc_mn_per_mm;
  EXPECT_NEAR(loop.snapshot().counters.leak_j, (kc / 2 - b / 0.003) * dx * dx, 1e-15);
  // A sample missed is a hold of two ticks.
  device_.sample.fresh = false;
  loop.Tick();
  device_.sample.fresh = true;
  device_.start_z -= 3;
  double before = loop.snapshot().counters.leak_j;
  loop.Tick();
  dx = 3 * params_.resolution_nm[2] * 1e-9;
  EXPECT_NEAR(loop.snapshot().counters.leak_j - before, (kc / 2 - b / 0.002) * dx * dx, 1e-15);
  EXPECT_EQ(loop.snapshot().counters.stale_ticks, 1u);
}

TEST_F(TickLoopTest, NoForceUntilTheDeviceWasStillAndThenOnlyFromZero) {
  core::CoreParams params = params_;
  params.soft_start_ticks = 50;
  core::Core core(params, volume_);
  SampleRing ring(8000);
  device_.still_s = 0.1;
  TickLoop loop(device_, core, ring, {1000, false, true});
  // Plunges into the block at 100 mm/s, like a person grabbing it: no force, no cut.
  device_.step = 10;
  for (int i = 0; i < 90; ++i) {
    loop.Tick();
    ASSERT_EQ(device_.last_force, dvec3(0));
  }
  EXPECT_EQ(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)], 0);
  // Back above it and still; then slowly down. The force begins at 0 and grows by at most Kc times
  // the distance per tick.
  Sample s;
  while (ring.Pop(s)) {
  }
  device_.reads = 0;
  device_.step = 0;
  for (int i = 0; i < 99; ++i) loop.Tick();
  while (ring.Pop(s)) EXPECT_TRUE(s.tick.input.flags & core::kSoftRestart);
  for (int i = 0; i < 100; ++i) loop.Tick();
  while (ring.Pop(s)) {
  }
  EXPECT_FALSE(s.tick.input.flags & core::kSoftRestart);
  device_.reads = 0;
  device_.step = 1;
  double last = 0, per_count = params.kc_mn_per_mm * params.resolution_nm[2] * 1e-9;
  for (int i = 0; i < 200; ++i) {
    loop.Tick();
    EXPECT_LE(device_.last_force.z, last + 2 * per_count) << i;
    last = device_.last_force.z;
  }
  EXPECT_GT(last, 0.1);
}

// --- another bur ---

TEST_F(TickLoopTest, AnotherBurComesInAirAtOnceAndFromTheToothOnceItIsOutOfIt) {
  params_.other_burs = {{cutting::BurShape::kSphere, 800'000},
                        {cutting::BurShape::kSphere, 300'000}};
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  loop.Tick();
  EXPECT_EQ(loop.snapshot().bur, 0);
  loop.WantBur(1);
  loop.Tick();
  EXPECT_EQ(loop.snapshot().bur, 1);
  EXPECT_FALSE(loop.snapshot().bur_waits);
  while (device_.last_force.z < 0.2) loop.Tick();
  loop.WantBur(2);
  for (int i = 0; i < 20; ++i) {
    loop.Tick();
    ASSERT_EQ(loop.snapshot().bur, 1);
    ASSERT_TRUE(loop.snapshot().bur_waits);
    ASSERT_GT(device_.last_force.z, 0);
  }
  // Up again, faster than it went down; still near the tooth at first.
  device_.start_z -= static_cast<int32_t>(device_.reads);
  device_.reads = 0;
  device_.step = -4;
  for (int i = 0; i < 200; ++i) loop.Tick();
  EXPECT_EQ(loop.snapshot().bur, 2);
  EXPECT_FALSE(loop.snapshot().bur_waits);
  std::vector<size_t> burs;
  for (Sample s; ring.Pop(s);) {
    const size_t bur = core::BurIn(s.tick.input.flags);
    if (burs.empty() || burs.back() != bur) burs.push_back(bur);
  }
  EXPECT_EQ(burs, (std::vector<size_t>{0, 1, 2})) << "as recorded";
}

// --- the handpiece in its holder ---

TEST_F(TickLoopTest, AHandpieceThatLiesInItsHolderWhenItBeginsEndsNothingAndHasNoForce) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.sample.buttons = kPedal | kPutDown;
  for (int i = 0; i < 300; ++i) {
    ASSERT_FALSE(loop.Tick());
    ASSERT_EQ(device_.last_force, dvec3(0));
  }
  EXPECT_EQ(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)], 0);
  EXPECT_EQ(loop.snapshot().counters.put_downs, 0u);  // it was there already
  EXPECT_TRUE(loop.snapshot().put_down);
}

TEST_F(TickLoopTest, PutDownInTheMiddleForceAndBurGoOffAndComeBackSoftlyWhenItIsTakenUp) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  device_.still_s = 0.1;
  device_.step = 0;
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 120; ++i) loop.Tick();
  device_.reads = 0;
  device_.step = 1;
  for (int i = 0; i < 200 && device_.last_force.z < 0.2; ++i) loop.Tick();
  ASSERT_GE(device_.last_force.z, 0.2);
  Sample s;
  for (int time = 1; time <= 2; ++time) {
    while (ring.Pop(s)) {
    }
    device_.sample.buttons = kPedal | kPutDown;
    auto removed = core.removed();
    for (int i = 0; i < 50; ++i) {
      ASSERT_FALSE(loop.Tick());
      ASSERT_EQ(device_.last_force, dvec3(0));
      ASSERT_TRUE(ring.Pop(s));
      ASSERT_EQ(s.tick.input.flags & core::kBurOn, 0);
    }
    // Tissue that the bur had passed but not yet cut is cut, within a voxel; nothing afterwards.
    EXPECT_LE(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)] -
                  removed[static_cast<size_t>(cutting::Tissue::kGypsum)],
              65536 * 200);
    EXPECT_EQ(loop.snapshot().counters.put_downs, static_cast<uint64_t>(time));
    // Taken up above the block: still for as long as the device asks, then the bur turns.
    device_.sample.buttons = kPedal;
    device_.reads = 0;
    device_.step = 0;
    int suspended = 0;
    for (; suspended < 1000; ++suspended) {
      loop.Tick();
      ASSERT_TRUE(ring.Pop(s));
      if ((s.tick.input.flags & core::kSoftRestart) == 0) break;
    }
    EXPECT_NEAR(suspended, 100, 2);
    EXPECT_TRUE(s.tick.input.flags & core::kBurOn);
    EXPECT_EQ(loop.fault(), Fault::kNone);
    device_.step = 1;
    for (int i = 0; i < 200 && device_.last_force.z < 0.2; ++i) loop.Tick();
    ASSERT_GE(device_.last_force.z, 0.2);
  }
}

TEST_F(InterruptedTest, ADeviceThatSwitchedItsMotorsOffHasNoForceUntilItDrivesAndIsInFreeAir) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  device_.still_s = 0.05;
  device_.step = 0;
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 60; ++i) loop.Tick();
  GoDown();
  Touch(loop);
  device_.sample.driven = false;
  loop.Tick();
  EXPECT_EQ(loop.fault(), Fault::kSwitchedOff);
  EXPECT_EQ(device_.last_force, dvec3(0));
  device_.sample.driven = true;
  for (int i = 0; i < 400; ++i) {
    loop.Tick();
    ASSERT_EQ(device_.last_force, dvec3(0));
  }
  EXPECT_EQ(loop.fault(), Fault::kNone);
  LiftOut(loop, 200);
  GoDown();
  for (int i = 0; i < 400 && device_.last_force.z < 0.2; ++i) loop.Tick();
  EXPECT_GE(device_.last_force.z, 0.2);
}

// --- time ---

TEST_F(TickLoopTest, PeriodsThatPassWhileATickIsLateAreDeclaredExactly) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, false});
  device_.step = 0;
  Sample s;
  uint64_t passed = 0;
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const uint32_t skipped = random() % 10 == 0 ? random() % 6000 : 0;
    loop.Tick(1e-3 * skipped + 1e-6 * (random() % 1000));
    ASSERT_TRUE(ring.Pop(s));
    ASSERT_EQ(s.tick.input.gap_ticks, skipped) << i;
    ASSERT_EQ((s.tick.input.flags & core::kLateTick) != 0, skipped > 0);
    ASSERT_EQ((s.tick.input.flags & core::kHeldGap) != 0, skipped > 0);
    passed += 1 + skipped;
    ASSERT_EQ(loop.snapshot().counters.passed_ticks(), passed);
  }
  EXPECT_EQ(loop.snapshot().counters.gap_ticks, 0u);
}

// The same motion, once in time and once with skipped periods. The force in the tick after a skip
// equals the one without it, within the effect of the missed distance; nothing is suspended.
TEST_F(TickLoopTest, APeriodThatIsSkippedIsNotFelt) {
  auto forces = [&](bool late) {
    ScriptedDevice device;
    device.start_z = device_.start_z;
    device.step = 1;
    device.sample.buttons = kPedal;
    core::Core core(params_, volume_);
    SampleRing ring(4000);
    TickLoop loop(device, core, ring, {1000, false, true});
    std::vector<double> out;
    for (int i = 0; i < 200; ++i) {
      if (late && i > 60 && i % 60 < 3) {
        ++device.reads;
        loop.Tick(0.0011);
        ++i;
      } else {
        loop.Tick();
      }
      out.resize(static_cast<size_t>(i) + 1, device.last_force.z);
      EXPECT_EQ(loop.snapshot().output_flags & core::kSuspended, i < 2 ? core::kSuspended : 0) << i;
    }
    EXPECT_EQ(loop.fault(), Fault::kNone);
    return out;
  };
  std::vector<double> whole = forces(false), late = forces(true);
  const double per_count = params_.kc_mn_per_mm * params_.resolution_nm[2] * 1e-9;
  ASSERT_GT(whole.back(), 0.3);
  for (size_t i = 0; i < std::min(whole.size(), late.size()); ++i) {
    EXPECT_NEAR(whole[i], late[i], 4 * per_count) << i;
  }
}

TEST_F(TickLoopTest, GapsOfBothKindsAreDeclaredTogetherAsOneWithoutForce) {
  core::Core core(params_, volume_);
  SampleRing ring(60);
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 60; ++i) loop.Tick();
  loop.Tick(0.0021);
  for (int i = 0; i < 4; ++i) loop.Tick();
  Sample s;
  while (ring.Pop(s)) {
  }
  loop.Tick(0.0012);
  ASSERT_TRUE(ring.Pop(s));
  EXPECT_EQ(s.tick.input.gap_ticks, 8u);
  EXPECT_EQ(s.tick.input.flags & core::kHeldGap, 0);
  EXPECT_EQ(loop.snapshot().counters.gap_ticks, 5u);
  EXPECT_EQ(loop.snapshot().counters.skipped_ticks, 3u);
  EXPECT_EQ(loop.snapshot().counters.passed_ticks(), 69u);
}

TEST_F(TickLoopTest, WhatIsRecordedWithSkippedPeriodsReplaysToTheSameState) {
  core::Core core(params_, volume_), again(params_, volume_);
  SampleRing ring(4);
  TickLoop loop(device_, core, ring, {1000, false, false});
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    if (i % 400 == 399) device_.reads = 0;
    loop.Tick(random() % 5 == 0 ? 1e-6 * (random() % 9000) : 0);
    Sample s;
    ASSERT_TRUE(ring.Pop(s));
    ASSERT_EQ(again.Step(s.tick.input).witness, s.tick.witness);
    ASSERT_EQ(again.state_hash(), s.state_hash);
  }
  EXPECT_GT(core.removed()[static_cast<size_t>(cutting::Tissue::kGypsum)], 0);
}

// Ticks begin at any time. The oracle knows by the clock when each did, and when each report was
// seen; the loop knows only lateness.
TEST_F(TickLoopTest, SilenceIsWhatPassedByTheClockHoweverLateTheTicksAre) {
  int faults = 0, alive = 0;
  for (uint32_t seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const uint32_t rate = seed % 3 == 0 ? 500 : seed % 3 == 1 ? 1000 : 4000;
    const int64_t period_us = 1'000'000 / rate;
    core::CoreParams params = params_;
    params.rate_hz = rate;
    core::Core core(params, volume_);
    SampleRing ring(4);
    ScriptedDevice device;
    TickLoop loop(device, core, ring, {rate, false, false});
    const bool steady = seed % 2 == 0;
    int64_t due_us = 0, last_report_us = 0, next_report_us = 0;
    for (int i = 0; i < 300; ++i) {
      due_us += period_us;
      const int64_t late_us = steady ? period_us * 9 / 10
                              : random() % 8 == 0
                                  ? random() % (3 * static_cast<uint32_t>(period_us))
                                  : random() % 50;
      const int64_t now_us = due_us + late_us;
      device.sample.fresh = now_us >= next_report_us;
      if (device.sample.fresh) {
        last_report_us = now_us;
        next_report_us = now_us + 1000 + random() % (i < 150 ? 3000 : 9000);
      }
      loop.Tick(static_cast<double>(late_us) * 1e-6);
      Sample s;
      ring.Pop(s);
      const bool silent = now_us - last_report_us >= 5000;
      ASSERT_EQ(loop.counters().interruptions > 0, silent) << "seed " << seed << ", tick " << i;
      if (silent) {
        ++faults;
        break;
      }
      ++alive;
      due_us += late_us / period_us * period_us;
    }
  }
  EXPECT_GT(faults, 20);
  EXPECT_GT(alive, 10'000);
}

TEST_F(TickLoopTest, SteadyLatenessIsNoSilence) {
  core::Core core(params_, volume_);
  SampleRing ring(400);
  TickLoop loop(device_, core, ring, {1000, false, true});
  device_.step = 0;
  for (int i = 0; i < 300; ++i) {
    device_.sample.fresh = i % 4 == 0;
    loop.Tick(0.0009);
    ASSERT_EQ(loop.fault(), Fault::kNone) << i;
  }
}

TEST(DurationHistogramTest, BucketsCoverAllDurationsWithoutGapsOrOverlaps) {
  for (size_t i = 0; i + 1 < DurationHistogram::kBuckets; ++i) {
    uint64_t low = DurationHistogram::Floor_ns(i), high = DurationHistogram::Floor_ns(i + 1);
    ASSERT_LT(low, high);
    ASSERT_EQ(DurationHistogram::BucketOf(low), i);
    ASSERT_EQ(DurationHistogram::BucketOf(high - 1), i);
    if (i >= 32) {
      ASSERT_LE(high - low, low / 32 + 1);
    }
  }
  EXPECT_EQ(DurationHistogram::BucketOf(~uint64_t{0}), DurationHistogram::kBuckets - 1);
}

TEST(DurationHistogramTest, QuantilesAreWithinAThirtySecondOfTheTrueOnes) {
  DurationHistogram h;
  EXPECT_EQ(h.Quantile_ns(0.5), 0);
  for (int64_t i = 0; i < 100'000; ++i) h.Add(i * 17 % 100'000 * 10);  // 0 to 1 ms, each once
  h.Add(-5);
  EXPECT_EQ(h.count(), 100'001u);
  EXPECT_NEAR(h.mean_ns(), 499'990, 10);
  for (double share : {0.1, 0.5, 0.9, 0.99}) {
    EXPECT_NEAR(h.Quantile_ns(share), share * 1e6, share * 1e6 / 32) << share;
  }
  EXPECT_EQ(h.max_ns(), 999'990u);
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
