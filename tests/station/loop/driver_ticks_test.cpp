#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <mutex>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/plan.h"
#include "station/devices/operators.h"
#include "station/devices/pointer_device.h"
#include "station/hid/foot_pedal.h"
#include "station/hid/haptic_board.h"
#include "station/hid/space_mouse.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "station/loop/tick_loop.h"
#include "station/render/brick_feed.h"
#include "station/sdk/open_sdk_device.h"
#include "station/uplink/live_mailbox.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/doubled_arm.h"
#include "tests/station/sdk/emulated_arms.h"
#include "tests/station/sdk/emulated_falcon.h"
#include "tests/support/tick_guard.h"

// Prohibited actions of a tick, checked with every driver, and with a stalled consumer.
namespace enamel::station {
namespace {

using enamel::testing_support::TickGuard;
using testing_support::HidBus;
using testing_support::ScriptedHid;

constexpr const char* kBoardPath = "/dev/hidraw4";
constexpr const char* kMousePath = "/dev/hidraw2";
constexpr const char* kPedalPath = "/dev/hidraw7";

struct World {
  scene::BuiltScene built;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  core::CoreParams params;
};

World MakeWorld() {
  auto built = scene::BuildBuiltinScene("block", 200'000);
  ENAMEL_CHECK(built.ok());
  World w{std::move(*built), {}, scene::BuiltinProfiles()[1], {}};
  w.exercise = scene::ClassOneExercise(w.built.scene, {});
  auto params = scene::CompilePlan(w.built.scene, w.exercise, w.profile);
  ENAMEL_CHECK(params.ok());
  w.params = *params;
  w.params.soft_start_ticks = 1;
  return w;
}

// A driver, and a function that gives its device new data. Feed returns when the driver has it.
struct Rig {
  std::unique_ptr<Device> device;
  std::function<void(int)> feed = [](int) {};
};

void Await(const std::function<bool()>& reached) {
  for (int i = 0; i < 10'000 && !reached(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(reached());
}

ScriptedHid Hid(const char* path, uint16_t vendor, uint16_t product) {
  ScriptedHid d;
  d.path = path;
  d.vendor = vendor;
  d.product = product;
  return d;
}

void SendPose(uint32_t sequence) {
  hid::InputReport r;
  r.sequence = sequence;
  r.time_us = sequence * 1000;
  r.counts = {static_cast<int32_t>(sequence % 7), 0, 100};
  r.buttons = 1;
  HidBus::Get().Send(kBoardPath, hid::EncodeInput(r));
}

Rig Board(const World&) {
  hid::FeatureReport f;
  f.resolution_nm.fill(10'000);
  f.peak_force_mn.fill(7'900);
  f.max_watchdog_ms = 100;
  f.rate_hz = 1000;
  ScriptedHid d = Hid(kBoardPath, 0x1209, 0x0001);
  d.usage_page = hid::kBoardUsagePage;
  d.usage = hid::kBoardUsage;
  auto bytes = hid::EncodeFeature(f);
  d.feature.assign(bytes.begin(), bytes.end());
  HidBus::Get().Plug(d);
  std::thread first([] {
    if (HidBus::Get().Await([](HidBus& b) { return b.handle_count() == 3; })) SendPose(1);
  });
  auto board = hid::HapticBoard::Open({});
  first.join();
  ENAMEL_CHECK(board.ok());
  auto shared = std::make_shared<uint32_t>(1);
  Device* raw = board->get();
  return {std::move(*board), [=](int) {
            SendPose(++*shared);
            Await([&] { return raw->counters().samples >= *shared; });
          }};
}

Rig MouseWithPedal(const World& w) {
  ScriptedHid mouse = Hid(kMousePath, 0x256f, 0xc62e);
  mouse.usage_page = hid::kMultiAxisPage;
  mouse.usage = hid::kMultiAxisUsage;
  HidBus::Get().Plug(mouse);
  HidBus::Get().Plug(Hid(kPedalPath, 0x05f3, 0x00ff));
  hid::DeviceChoice choice;
  choice.device = "spacemouse";
  choice.pedal = "05f3:00ff";
  auto device = hid::OpenDevice(choice, w.profile, 1e-3);
  ENAMEL_CHECK(device.ok());
  HidBus::Get().Await([](HidBus& b) { return b.handle_count() == 2; });
  Device* raw = device->get();
  return {std::move(*device), [raw](int i) {
            const auto deflected = static_cast<uint8_t>(i % 100);
            const uint8_t report[] = {1, deflected, 0, 0, 0, deflected, 0, 0, 0, 0, 0, 0, 0};
            const uint8_t pedal[] = {static_cast<uint8_t>(i % 2), 0};
            uint64_t before = raw->counters().samples;
            HidBus::Get().Send(kMousePath, report);
            HidBus::Get().Send(kPedalPath, pedal);
            Await([&] { return raw->counters().samples > before; });
          }};
}

Rig Pointer(const World& w) {
  auto device = std::make_unique<PointerDevice>(w.params.resolution_nm[0] * 1e-9, 1e-3);
  PointerDevice* raw = device.get();
  return {std::move(device), [raw](int i) {
            PointerPose pose;
            pose.offset_m = dvec3(0, 0, 1e-6 * i);
            pose.buttons = kPedal;
            raw->Publish(pose);
          }};
}

Rig Simulated(const World& w) {
  auto device = MakeSimulatedDevice(*FindOperator("dentist"), w.built.scene, w.exercise, w.profile,
                                    w.params, w.built.volume);
  ENAMEL_CHECK(device.ok());
  return {std::move(*device)};
}

// A device that one can buy: its emulator, or its double behind the maker's library, always has a pose.
Rig Arm(std::shared_ptr<testing_support::EmulatedArm> arm) {
  hid::DeviceChoice chosen;
  chosen.device = arm->choice();
  auto device = sdk::OpenChosenDevice(chosen, *scene::FindProfile(arm->profile()), 1e-3);
  ENAMEL_CHECK(device.ok());
  Device* raw = device->get();
  return {std::move(*device), [raw, arm](int) {
            uint64_t before = raw->counters().samples;
            Await([&] { return raw->counters().samples > before; });
          }};
}

Rig MakeRig(const std::string& driver, const World& w) {
  if (driver == "board") return Board(w);
  if (driver == "mouse") return MouseWithPedal(w);
  if (driver == "pointer") return Pointer(w);
  if (driver == "simulated") return Simulated(w);
  if (driver == "polhem") return Arm(std::make_shared<testing_support::EmulatedHidArm>(true));
  if (driver == "polhem_serial") return Arm(std::make_shared<testing_support::EmulatedSerialArm>());
  if (driver == "falcon") return Arm(std::make_shared<testing_support::EmulatedFalcon>());
  if (driver == "inverse3") return Arm(std::make_shared<lab::EmulatedInverse3>());
  return Arm(std::make_shared<testing_support::DoubledArm>(driver));
}

// Passes a driver's calls on and monitors them.
class Watched final : public Device {
 public:
  explicit Watched(Device& inner) : inner_(inner) {}
  std::string Name() const override { return inner_.Name(); }
  Hand hand() const override { return inner_.hand(); }
  DeviceSample ReadSample() noexcept override {
    ++reads;
    return inner_.ReadSample();
  }
  void SendForce(const dvec3& force_n) noexcept override {
    force = force_n;
    inner_.SendForce(force_n);
  }
  void ShowBur(const dvec3& tip_m) noexcept override { inner_.ShowBur(tip_m); }
  bool has_motors() const noexcept override { return inner_.has_motors(); }
  double still_before_force_s() const noexcept override { return inner_.still_before_force_s(); }
  DeviceCounters counters() const noexcept override { return inner_.counters(); }

  uint64_t reads = 0;
  dvec3 force{0};

 private:
  Device& inner_;
};

class DriverTicksTest : public testing::TestWithParam<std::string> {
 protected:
  DriverTicksTest() {
    Reset();
    rig_ = MakeRig(GetParam(), world_);
  }
  ~DriverTicksTest() override {
    rig_.device.reset();
    Reset();
  }
  static void Reset() { HidBus::Get().Reset(); }

  World world_ = MakeWorld();
  Rig rig_;
};

TEST_P(DriverTicksTest, ATickNeitherAllocatesNorLocksNorWaits) {
  core::Core core(world_.params, world_.built.volume);
  SampleRing ring(16);
  TickLoop loop(*rig_.device, core, ring, {1000, false, true});
  size_t allocations = 0, blocking = 0;
  Sample s;
  for (int i = 0; i < 400; ++i) {
    rig_.feed(i);
    {
      TickGuard guard;
      loop.Tick();
      allocations += guard.allocations();
      blocking += guard.blocking();
    }
    while (ring.Pop(s)) {
    }
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(blocking, 0u);
  EXPECT_EQ(core.ticks(), 400u);
  EXPECT_EQ(loop.snapshot().counters.faults, 0u);
}

TEST_P(DriverTicksTest, AStalledConsumerCostsForceAndCutIsDeclaredAndNeverStopsTheLoop) {
  constexpr size_t kRing = 40;
  Watched device(*rig_.device);
  core::Core core(world_.params, world_.built.volume);
  SampleRing ring(kRing);
  TickLoop loop(device, core, ring, {1000, false, true});
  size_t allocations = 0, blocking = 0;
  for (int i = 0; i < 300; ++i) {
    rig_.feed(i);
    TickGuard guard;
    loop.Tick();
    allocations += guard.allocations();
    blocking += guard.blocking();
    if (i >= static_cast<int>(kRing)) {
      ASSERT_EQ(device.force, dvec3(0)) << i;
    }
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(blocking, 0u);
  EXPECT_EQ(core.ticks(), kRing);
  EXPECT_EQ(device.reads, 300u);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  Sample s;
  while (ring.Pop(s)) EXPECT_EQ(s.tick.input.gap_ticks, 0u);
  rig_.feed(300);
  loop.Tick();
  ASSERT_TRUE(ring.Pop(s));
  EXPECT_EQ(s.tick.input.gap_ticks, 300 - kRing);
  EXPECT_EQ(loop.snapshot().counters.gap_ticks, 300 - kRing);
}

TEST_P(DriverTicksTest, AWindowThatReadsSlowlyOrNeverHoldsUpNothing) {
  core::Core core(world_.params, world_.built.volume);
  SampleRing ring(400);
  TickLoop loop(*rig_.device, core, ring, {1000, false, true});
  for (int i = 0; i < 100; ++i) {
    rig_.feed(i);
    loop.Tick();
  }
  EXPECT_EQ(core.ticks(), 100u);
  EXPECT_EQ(loop.snapshot().counters.ticks, 100u);  // the newest, however many it missed
}

INSTANTIATE_TEST_SUITE_P(Drivers, DriverTicksTest,
                         testing::Values("board", "mouse", "pointer", "simulated", "dhd",
                                         "openhaptics", "polhem", "polhem_serial", "inverse3",
                                         "falcon"),
                         [](const auto& param) { return param.param; });

// The consumers of a tick in the window and the uplink, as TickFeed and RunningAttempt, while
// neither reads: a window being opened or dragged, or hanging; a network failure.
class NobodyLooks final : public TickObserver {
 public:
  explicit NobodyLooks(const cutting::Volume& volume) : bricks_(volume.spec().brick_count(), 4) {}
  void OnTick(const core::Core& core, const Snapshot& snapshot) noexcept override {
    live_.Write({snapshot.counters.ticks, {}, {}, snapshot.output_flags});
    bricks_.Mark(core.touched());
    bricks_.Send(core.volume(), 8);
  }
  size_t waiting() const { return bricks_.dirty_count(); }

 private:
  LiveMailbox live_;
  render::BrickFeed bricks_;
};

TEST(ObservedTicksTest, AWindowThatHangsAndANetworkThatIsGoneHoldUpNoTick) {
  World world = MakeWorld();
  Rig rig = Simulated(world);
  core::Core core(world.params, world.built.volume), alone(world.params, world.built.volume);
  NobodyLooks observer(world.built.volume);
  SampleRing ring(16);
  TickLoop loop(*rig.device, core, ring, {1000, false, true}, &observer);
  size_t allocations = 0, blocking = 0;
  Sample s;
  for (int i = 0; i < 12'000; ++i) {
    {
      TickGuard guard;
      loop.Tick();
      allocations += guard.allocations();
      blocking += guard.blocking();
    }
    ASSERT_TRUE(ring.Pop(s));
    ASSERT_EQ(alone.Step(s.tick.input).witness, s.tick.witness);
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(blocking, 0u);
  EXPECT_GT(observer.waiting(), 4u);  // it did cut, and nobody fetched it
}

TEST(TickGuardTest, SeesALockAWaitAndAWrite) {
  if (!TickGuard::kSeesBlocking) GTEST_SKIP() << "skipped: a sanitizer stands in its place";
  std::mutex mutex;
  TickGuard guard;
  { std::lock_guard lock(mutex); }
  EXPECT_EQ(guard.blocking(), 1u);
  std::this_thread::sleep_for(std::chrono::microseconds(1));
  EXPECT_EQ(guard.blocking(), 2u);
  EXPECT_EQ(::write(-1, "", 0), -1);
  EXPECT_EQ(guard.blocking(), 3u);
}

}  // namespace
}  // namespace enamel::station
