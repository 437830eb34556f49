#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>

#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "station/devices/trouble.h"
#include "station/loop/tick_loop.h"
#include "station/sdk/buses.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/every_arm.h"
#include "tests/support/await_sample.h"
#include "tests/support/temp_folder.h"

// Devices of published protocols against emulators of their bytes, and those of makers' libraries against
// doubles of the libraries.
namespace enamel::station::sdk {
namespace {

using lab::EmulatedArm;
using lab::EmulatedInverse3;
using testing_support::ArmDrawing;
using testing_support::AwaitThat;
using testing_support::DoubledArm;
using testing_support::EmulatedFalcon;
using testing_support::EmulatedHidArm;
using testing_support::EmulatedSerialArm;
using testing_support::HidBus;
using testing_support::kArmDrawings;
using testing_support::MakeArm;

constexpr double kTurn = 2 * std::numbers::pi;

// Renews the force as the loop does: on a busy computer one that is sent once may fade before this thread
// looks.
void PushUntil(Device& device, const dvec3& force_n, const std::function<bool()>& reached) {
  AwaitThat([&] {
    device.SendForce(force_n);
    return reached();
  });
}

Result<std::unique_ptr<Device>> Open(const EmulatedArm& arm) {
  hid::DeviceChoice choice;
  choice.device = arm.choice();
  return OpenChosenDevice(choice, *scene::FindProfile(arm.profile()), 1e-3);
}

// With its first pose, which is the middle.
std::unique_ptr<Device> MustOpen(const EmulatedArm& arm) {
  auto device = Open(arm);
  EXPECT_TRUE(device.ok()) << device.status().message();
  if (!device.ok()) return nullptr;
  AwaitThat([&] { return (*device)->counters().samples > 0; });
  return std::move(*device);
}

// A sample of an exchange that began after this call.
DeviceSample Next(Device& device) {
  const uint64_t before = device.counters().samples;
  AwaitThat([&] { return device.counters().samples >= before + 2; });
  return device.ReadSample();
}

constexpr int kForces = 5;  // that an arm is told apart by

// Without PolledDevice's thread.
std::unique_ptr<PolledBus> OpenBus(const EmulatedArm& arm) {
  const std::string choice = arm.choice();
  const size_t colon = choice.find(':');
  const BusChoice wanted{colon == choice.npos ? "" : choice.substr(colon + 1), 5, 0.15};
  const std::string driver = choice.substr(0, colon);
  auto bus = driver == "polhem_serial"   ? OpenPolhemSerial(wanted)
             : driver == "inverse3"      ? OpenInverse3(wanted)
             : driver == "falcon"        ? OpenFalcon(wanted)
             : driver == "woodenhaptics" ? OpenWoodenHaptics(wanted)
                                         : OpenPolhem(wanted);
  EXPECT_TRUE(bus.ok()) << bus.status().message();
  return bus.ok() ? std::move(*bus) : nullptr;
}

class ArmsTest : public testing::TestWithParam<const char*> {
 protected:
  ArmsTest() { HidBus::Get().Reset(); }
};
// Those that say where they are only in answer to a force.
using AnsweringArmsTest = ArmsTest;

TEST_P(ArmsTest, ItIsAskedAtForceZeroWhileTheLoopIsSilent) {
  auto arm = MakeArm(GetParam());
  auto device = MustOpen(*arm);
  PushUntil(*device, dvec3(0, 0, 1), [&] { return arm->told() != std::array<int, 3>{}; });
  // The station's keeper ends the force; the requests that feed the watchdog continue.
  AwaitThat([&] { return arm->told() == std::array<int, 3>{}; });
  const uint64_t before = arm->requests();
  AwaitThat([&] { return arm->requests() > before + 20; });
  EXPECT_EQ(arm->told(), (std::array<int, 3>{}));
}

TEST_P(ArmsTest, EndsWithForceZero) {
  auto arm = MakeArm(GetParam());
  auto device = MustOpen(*arm);
  PushUntil(*device, dvec3(0, 0, 1), [&] { return arm->told() != std::array<int, 3>{}; });
  device.reset();
  AwaitThat([&] { return arm->told() == std::array<int, 3>{}; });
}

TEST_P(ArmsTest, ASecondSessionIsRefusedUntilTheFirstEnds) {
  auto arm = MakeArm(GetParam());
  auto device = MustOpen(*arm);
  const Status refused = Open(*arm).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("in use"), std::string::npos) << refused.message();
  device.reset();
  EXPECT_NE(MustOpen(*arm), nullptr);
}

TEST_P(ArmsTest, OneThatSaysNothingIsRefusedWithWhatToDo) {
  auto arm = MakeArm(GetParam());
  arm->Mute(true);
  const Status refused = Open(*arm).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("sends no pose"), std::string::npos) << refused.message();
}

// What the arm gets for a force that is renewed, once 20 requests in a row have the same: while this
// thread is kept from running the force fades, from one request to the next.
std::array<int, 3> ToldOf(Device& device, const EmulatedArm& arm, const dvec3& force_n) {
  std::array<int, 3> told{};
  uint64_t since = arm.requests();
  PushUntil(device, force_n, [&] {
    const uint64_t requests = arm.requests();
    if (const auto now = arm.told(); now != told || now == std::array<int, 3>{}) {
      told = now;
      since = requests;
    }
    return requests > since + 20;
  });
  return told;
}

TEST_P(ArmsTest, AForceIsShortenedToTheProfilesPeak) {
  auto arm = MakeArm(GetParam());
  auto device = MustOpen(*arm);
  const double peak_n = scene::FindProfile(arm->profile())->peak_force_mn.value * 1e-3;
  const auto peak = ToldOf(*device, *arm, dvec3(0, 0, peak_n));
  EXPECT_NE(peak, (std::array<int, 3>{}));
  EXPECT_EQ(ToldOf(*device, *arm, dvec3(0, 0, 100 * peak_n)), peak);
  EXPECT_NE(ToldOf(*device, *arm, dvec3(0, 0, 0.3 * peak_n)), peak);
}

// Passes a driver's calls on. The pedal is down, and force may come on at once.
class Held final : public Device {
 public:
  explicit Held(Device& inner) : inner_(inner) {}
  std::string Name() const override { return inner_.Name(); }
  Hand hand() const override { return inner_.hand(); }
  DeviceSample ReadSample() noexcept override {
    DeviceSample s = inner_.ReadSample();
    s.buttons = kPedal;
    s.bur_speed_krpm = kTurbineSpeed_krpm;
    return s;
  }
  void SendForce(const dvec3& force_n) noexcept override {
    force = force_n;
    inner_.SendForce(force_n);
  }
  dvec3 force{0};

 private:
  Device& inner_;
};

// The block under a bur that begins 0.5 mm above it, held by a device with this profile.
struct Plan {
  core::CoreParams params;
  cutting::Volume volume;
};

Plan PlanFor(const char* name) {
  auto built = scene::BuildBuiltinScene("block", 200'000);
  ENAMEL_CHECK(built.ok());
  const auto profile = scene::FindProfile(name);
  auto params =
      scene::CompilePlan(built->scene, scene::ClassOneExercise(built->scene, {}), *profile);
  ENAMEL_CHECK(params.ok());
  params->soft_start_ticks = 1;
  params->device_origin_nm[2] =
      int64_t{built->scene.landmarks.at("occlusal_centre")[2]} * 1000 + 500'000;
  return {*params, std::move(built->volume)};
}

// A device in the loop, ticked by the test: its time is that of the ticks.
class Session {
 public:
  Session(EmulatedArm& arm, const Plan& plan)
      : arm_(arm),
        device_(MustOpen(arm)),
        held_(*device_),
        core_(plan.params, plan.volume),
        loop_(held_, core_, ring_, {1000, false, true}) {}

  // With the next answer, unless none comes any more.
  void Tick(int step) {
    arm_.Lower(step);
    const uint64_t before = device_->counters().samples;
    AwaitThat([&] { return device_->counters().samples > before || arm_.is_cut(); });
    Tick();
  }
  void Tick() {
    loop_.Tick();
    Sample s;
    while (ring_.Pop(s)) {
    }
  }
  Fault fault() const { return loop_.fault(); }
  const dvec3& force() const { return held_.force; }
  DeviceCounters counters() const { return device_->counters(); }

 private:
  EmulatedArm& arm_;
  std::unique_ptr<Device> device_;
  Held held_;
  core::Core core_;
  SampleRing ring_{64};
  TickLoop loop_;
};

// Until the tooth pushes back.
int Touch(Session& session) {
  int step = 0;
  // Force comes on in free air only.
  for (int i = 0; i < 5; ++i) session.Tick(step);
  while (session.force() == dvec3(0) && step < 100) session.Tick(++step);
  EXPECT_NE(session.force(), dvec3(0));
  EXPECT_EQ(session.fault(), Fault::kNone);
  return step;
}

TEST_P(ArmsTest, LostAnswersCostNoFault) {
  auto arm = MakeArm(GetParam());
  const Plan plan = PlanFor(arm->profile());
  Session session(*arm, plan);
  int step = Touch(session);
  for (int i = 0; i < 60; ++i) {
    session.Tick(step);
    // The answers to the next two ticks.
    arm->Mute(true);
    for (int lost = 0; lost < 2; ++lost) {
      const uint64_t before = arm->requests();
      AwaitThat([&] { return arm->requests() > before; });
      session.Tick();
    }
    arm->Mute(false);
  }
  EXPECT_EQ(session.fault(), Fault::kNone);
}

// 1000 sessions with ENAMEL_FULL=1. Cut at any byte, or any call of a maker's library. Ticks are counted from
// the last whole answer, or from the tick in which the driver's thread knows that the port is closed.
TEST_P(ArmsTest, CutAtAnyByteTheForceIsZeroInTimeAndAFaultFollows) {
  const int sessions = std::getenv("ENAMEL_FULL") != nullptr ? 1000 : 40;
  const Plan plan = PlanFor(MakeArm(GetParam())->profile());
  std::mt19937 random(39);
  int most_silent = 0, most_closed = 0;
  for (int i = 0; i < sessions; ++i) {
    auto arm = MakeArm(GetParam());
    Session session(*arm, plan);
    int step = Touch(session);
    const bool closed = i % 2 == 1;
    arm->CutAfter(random() % (6 * arm->answer_bytes()));
    uint64_t samples = session.counters().samples;
    int ticks = 0;  // since the last answer
    while (!arm->is_cut()) {
      session.Tick(++step);
      ticks = session.counters().samples == samples ? ticks + 1 : 0;
      samples = session.counters().samples;
    }
    if (closed) {
      arm->Unplug();
      AwaitThat([&] { return session.counters().detached == 1; });
      ticks = 0;
    }
    do {
      session.Tick();
      ++ticks;
    } while (session.force() != dvec3(0) && ticks < 100);
    int& most = closed ? most_closed : most_silent;
    most = std::max(most, ticks);
    ASSERT_LE(ticks, closed ? 2 : 7) << i;
    for (int k = 0; k < 110 && session.fault() == Fault::kNone; ++k) {
      session.Tick();
      ASSERT_EQ(session.force(), dvec3(0)) << i;
    }
    ASSERT_EQ(session.fault(), closed ? Fault::kUnplugged : Fault::kStalled) << i;
    if (!closed) AwaitThat([&] { return arm->told() == std::array<int, 3>{}; });
  }
  std::printf("%s, %d sessions: %d ticks after the last answer, %d after a closed port\n",
              GetParam(), sessions, most_silent, most_closed);
}

// An answer is to the last question if the device was last told that question's force.
TEST_P(AnsweringArmsTest, AnAnswerThatIsTooLateIsNotTakenForTheNextOnesFromThenOn) {
  auto arm = MakeArm(GetParam());
  auto bus = OpenBus(*arm);
  ASSERT_NE(bus, nullptr);
  PolledBus::Pose pose;
  const auto exchange = [&](int number) {
    EXPECT_TRUE(bus->Send(dvec3(0, 0, 0.1 * (number % kForces))));
    return bus->Read(pose);
  };
  std::array<std::array<int, 3>, kForces> told;
  for (int i = 0; i < kForces; ++i) {
    const uint64_t before = arm->requests();
    exchange(i);
    AwaitThat([&] { return arm->requests() > before; });
    told[static_cast<size_t>(i)] = arm->told();
  }
  arm->Delay(std::chrono::milliseconds(6), {});
  EXPECT_EQ(exchange(0), PolledBus::Heard::kNothing);
  const std::chrono::microseconds delay(1500);
  arm->Delay(delay, {});
  const auto now_ns = [] {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  int heard = 0, own = 0;
  for (int i = 1; i <= 40; ++i) {
    if (exchange(i) != PolledBus::Heard::kPose) continue;
    ++heard;
    own += arm->told() == told[static_cast<size_t>(i % kForces)];
    EXPECT_GE(now_ns() - pose.asked_ns, std::chrono::nanoseconds(delay).count());
  }
  // All but the first, and those that are late on a busy computer. None, where one late answer shifts the rest.
  EXPECT_GT(own, heard / 4);
  std::printf("%s: %d of %d answers to their own question\n", GetParam(), own, heard);
}

TEST_P(AnsweringArmsTest, SlowAnswersAreWaitedForAndThoseThatWouldBeAFaultAreRefused) {
  auto arm = MakeArm(GetParam());
  arm->Delay(std::chrono::microseconds(2200), {});
  // On a busy computer half of them can take twice as long.
  auto device = Open(*arm);
  for (int i = 0; i < 5 && !device.ok(); ++i) device = Open(*arm);
  ASSERT_TRUE(device.ok()) << device.status().message();
  AwaitThat([&] { return (*device)->counters().samples > 0; });
  Next(**device);
  EXPECT_GE((*device)->answer_time()->median_us, 2200);
  device->reset();
  arm->Delay(std::chrono::milliseconds(7), {});
  const Status refused = Open(*arm).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("more than 4 ms for half of its answers"), std::string::npos)
      << refused.message();
}

constexpr auto kAnswering = {"woodenhaptics", "polhem", "polhem_serial", "inverse3", "falcon"};
const auto kNamed = [](const auto& param) { return std::string(param.param); };
INSTANTIATE_TEST_SUITE_P(Answering, AnsweringArmsTest, testing::ValuesIn(kAnswering), kNamed);
INSTANTIATE_TEST_SUITE_P(Answering, ArmsTest, testing::ValuesIn(kAnswering), kNamed);
INSTANTIATE_TEST_SUITE_P(Makers, ArmsTest, testing::Values("dhd", "openhaptics"), kNamed);

TEST(HidArmTest, ItsTipIsWhereTheDrawingPutsIt) {
  for (const ArmDrawing& d : kArmDrawings) {
    EmulatedHidArm arm(d.polhem);
    auto device = MustOpen(arm);
    const auto start = arm.counters();
    const double cell = scene::CountNm(*scene::FindProfile(arm.profile())) * 1e-9;
    for (const std::array<int, 3> by :
         {std::array{300, 0, 0}, {0, 200, 0}, {0, 0, -250}, {-99, 50, 70}}) {
      auto at = start;
      for (size_t i = 0; i < 3; ++i) at[i] += by[i];
      arm.Set(at);
      const DeviceSample s = Next(*device);
      const dvec3 moved = TipOf(d, at) - TipOf(d, start);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(s.counts[static_cast<size_t>(i)] * cell, moved[i], cell) << i;
      }
    }
  }
}

// Virtual work: a motor's torque over its turn is the force over the tip's way.
TEST(HidArmTest, ItsCurrentsDoTheForcesWork) {
  const dvec3 force{0.3, -0.5, 0.7};
  for (const ArmDrawing& d : kArmDrawings) {
    EmulatedHidArm arm(d.polhem);
    auto at = arm.counters();
    at[0] += 400;
    arm.Set(at);
    auto device = MustOpen(arm);
    std::array<double, 3> expected;
    for (size_t i = 0; i < 3; ++i) {
      auto ahead = at, behind = at;
      ++ahead[i];
      --behind[i];
      const double work_j = Dot(force, TipOf(d, ahead) - TipOf(d, behind));
      const double body_rad = -2 / 2000.0 * kTurn / d.gear[i];
      expected[i] = d.sign[i] * work_j / body_rad / d.gear[i] / d.k * 1e3;
    }
    // Within 1 mA, while it is pushed: the station's keeper takes back a force that nobody asks for again.
    PushUntil(*device, force, [&] {
      const auto told = arm.told();
      bool all = true;
      for (size_t i = 0; i < 3; ++i) all &= std::abs(told[i] - expected[i]) <= 1;
      return all;
    });
    // Beyond 2 A the direction stays.
    std::array<int, 3> strong;
    PushUntil(*device, force * 5.0, [&] {
      strong = arm.told();
      return std::abs(strong[1]) > 1.5 * std::abs(expected[1]);
    });
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_LE(std::abs(strong[i]), d.polhem && i == 0 ? 1000 : 2000);
      EXPECT_NEAR(1.0 * strong[i] / strong[1], expected[i] / expected[1], 0.02) << i;
    }
  }
}

// As the other emulated arms: 40 um a step, from where it was opened.
TEST(HidArmTest, LoweredItGoesStraightDown) {
  for (const ArmDrawing& d : kArmDrawings) {
    EmulatedHidArm arm(d.polhem);
    const dvec3 start_m = TipOf(d, arm.counters());
    for (const int steps : {0, 100, 300}) {
      arm.Lower(steps);
      const dvec3 moved_m = TipOf(d, arm.counters()) - start_m;
      EXPECT_NEAR(moved_m.x, 0, 0.1e-3);
      EXPECT_NEAR(moved_m.y, 0, 0.1e-3);
      EXPECT_NEAR(moved_m.z, -steps * 40e-6, 0.1e-3);
    }
  }
}

TEST(HidArmTest, CountersThatWrapMoveNothing) {
  EmulatedHidArm arm(false);
  auto at = arm.counters();
  at[0] = 32'760;  // a whole turn and 8 degrees
  arm.Set(at);
  auto device = MustOpen(arm);
  Next(*device);
  at[0] = 32'776 - 65'536;
  arm.Set(at);
  const double way = dvec3(TipOf(kArmDrawings[0], {32'776, at[1], at[2]})).x -
                     TipOf(kArmDrawings[0], {32'760, at[1], at[2]}).x;
  EXPECT_NEAR(Next(*device).counts[0] * 500e-9, way, 1e-6);
  EXPECT_LT(std::abs(way), 2e-3);
}

TEST(HidArmTest, RestartedInASessionItCountsAsUnplugged) {
  EmulatedHidArm arm(true);
  auto device = MustOpen(arm);
  Next(*device);
  arm.Set({});
  test::AwaitSample(*device, [](const DeviceSample& s) { return !s.attached; });
}

TEST(HidArmTest, WithoutCalibrationItIsRefusedWithHowToDoIt) {
  for (bool polhem : {false, true}) {
    EmulatedHidArm arm(polhem);
    arm.Set({30, -20, 10, 0, 0, 0});
    const Status refused = Open(arm).status();
    EXPECT_EQ(refused.code(), Code::kUnavailable);
    for (const char* said : {"not calibrated", "home pose", polhem ? "press" : "switch it on"}) {
      EXPECT_NE(refused.message().find(said), std::string::npos) << refused.message();
    }
  }
}

TEST(HidArmTest, AfterItsButtonWasPressedItGetsItsCounters) {
  EmulatedHidArm arm(true);
  arm.PressCalibration();
  EXPECT_NE(MustOpen(arm), nullptr);
  EXPECT_TRUE(arm.calibrated_to_home());
}

TEST(HidArmTest, TheOtherFirmwaresReportsAreNamed) {
  EmulatedHidArm arm(true);
  HidBus::Get().Unplug(arm.path());
  testing_support::ScriptedHid wrong;
  wrong.path = arm.path();
  wrong.vendor = 0x1234;
  wrong.product = 0x0006;
  wrong.answer = [](ByteView) { return Bytes(8); };
  HidBus::Get().Plug(wrong);
  const Status refused = Open(arm).status();
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("8 bytes, expected 14"), std::string::npos) << refused.message();
}

// Gimbal counter d turns the tool about its own axis: a quarter of 1024 the wrong way round, about the
// arm's x, which is the scene's -y.
TEST(HidArmTest, ItsGimbalTurnsTheTool) {
  EmulatedHidArm arm(true);
  auto at = arm.counters();
  at[1] = 0;
  at[2] = -5000;  // body c level: the tool's frame is the arm's
  auto device = MustOpen(arm);
  arm.Set(at);
  const Quat level = FromQuantised(Next(*device).orientation);
  EXPECT_NEAR(level.w, 1, 1e-3);
  at[3] = 256;
  arm.Set(at);
  const Quat turned = FromQuantised(Next(*device).orientation);
  EXPECT_NEAR(turned.y, std::sqrt(0.5), 1e-3);
  EXPECT_NEAR(turned.w, std::sqrt(0.5), 1e-3);
}

TEST(HidArmTest, BothFirmwaresOfItsIdsAreListedWithTheirProfiles) {
  HidBus::Get().Reset();
  EmulatedHidArm arm(true);
  std::vector<std::string> listed;
  for (const SdkDevice& d : ListSdkDevices()) {
    if (d.ids != "1234:0006") continue;
    listed.push_back(d.choice + " " + d.profile);
    EXPECT_TRUE(d.problem.ok()) << d.problem.message();
    const std::string asked = AskedForText(d);
    for (const char* member : {"damping_mn_s_per_m", "friction_mn", "mass_g", "continuous_force_mn",
                               "enamel-station calibrate --device "}) {
      EXPECT_NE(asked.find(member), std::string::npos) << asked;
    }
  }
  EXPECT_EQ(listed,
            (std::vector<std::string>{"woodenhaptics woodenhaptics_v2015", "polhem polhem_v1"}));
}

TEST(SerialArmTest, ItsTipAndForceAreTurnedToTheSceneAndBack) {
  EmulatedSerialArm arm;
  auto device = MustOpen(arm);
  // Toward the user 1 mm, right 2, up 3; turned by a quarter about its z, which is the scene's.
  arm.Set({1, 2, 3}, {kTurn / 4, 0, 0, 0});
  const DeviceSample s = Next(*device);
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{4000, -2000, 6000}));
  EXPECT_NEAR(FromQuantised(s.orientation).z, std::sqrt(0.5), 1e-3);
  PushUntil(*device, dvec3(0.1, 0.2, -0.3), [&] {
    return arm.told() == std::array<int, 3>{-200, 100, -300};
  });
}

TEST(SerialArmTest, AnswersInPiecesAfterEmptyLinesAreRead) {
  EmulatedSerialArm arm;
  arm.InPieces(true);
  auto device = MustOpen(arm);
  arm.Set({0, 0, 1});
  test::AwaitSample(*device, [](const DeviceSample& s) { return s.counts[2] == 2000; });
}

TEST(SerialArmTest, AnAnswerThatLostAByteMovesNothing) {
  EmulatedSerialArm arm;
  arm.Set({0, 0, 0});
  auto device = MustOpen(arm);
  Next(*device);
  arm.LoseAByte(true);
  AwaitThat([&] { return device->counters().refused >= 5; });
  EXPECT_EQ(device->ReadSample().counts, (std::array<int32_t, 3>{}));
  arm.LoseAByte(false);
  Next(*device);
}

TEST(SerialArmTest, WithoutCalibrationItIsRefusedAndItsButtonSetsItsCounters) {
  EmulatedSerialArm arm;
  arm.Set({0, 20, 170});
  const Status refused = Open(arm).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  for (const char* said : {"171 mm", "150 mm", "not calibrated", "calibration button"}) {
    EXPECT_NE(refused.message().find(said), std::string::npos) << refused.message();
  }
  arm.PressCalibration();
  EXPECT_NE(MustOpen(arm), nullptr);
  EXPECT_TRUE(arm.calibrated_to_home());
}

TEST(SerialArmTest, APortThatIsNotThereIsNamed) {
  hid::DeviceChoice choice;
  choice.device = "polhem_serial:/dev/ttyNONE";
  const auto profile = *scene::FindProfile("polhem_v3");
  const Status refused = OpenChosenDevice(choice, profile, 1e-3).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("/dev/ttyNONE"), std::string::npos) << refused.message();
}

TEST(Inverse3Test, ItsTipAndForceHaveTheScenesAxes) {
  EmulatedInverse3 service;
  service.Set({0.01, 0.15, 0.1});
  auto device = MustOpen(service);
  service.Set({0.011, 0.152, 0.097});
  EXPECT_EQ(Next(*device).counts, (std::array<int32_t, 3>{2000, 4000, -6000}));
  PushUntil(*device, dvec3(0.1, 0.2, -0.3), [&] {
    return service.told() == std::array<int, 3>{100, 200, -300};
  });
}

TEST(Inverse3Test, BothFormsOfAForceAreSentAsTheServiceTakesThem) {
  for (const char* form : {"vector", "values"}) {
    EmulatedInverse3 service;
    service.Take(form);
    auto device = MustOpen(service);
    PushUntil(*device, dvec3(0, 0, 1), [&] {
      return service.told() == std::array<int, 3>{0, 0, 1000};
    });
  }
  EmulatedInverse3 service;
  service.Take("something_else");
  const Status refused = Open(service).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("vector or values"), std::string::npos) << refused.message();
}

// A bur points along its own -z, a grip along its own y.
TEST(Inverse3Test, ItsGripTurnsTheBurAndItsButtonRunsIt) {
  for (bool wireless : {false, true}) {
    EmulatedInverse3 service;
    auto device = MustOpen(service);
    service.Grip({0, 0, 0, 1}, true, wireless);
    const DeviceSample s = Next(*device);
    const dvec3 bur = FromQuantised(s.orientation).Matrix() * dvec3(0, 0, -1);
    EXPECT_NEAR(bur.y, 1, 1e-3);
    EXPECT_EQ(s.buttons, kPedal) << wireless;
    service.Grip({0, 0, 0, 1}, false, wireless);
    EXPECT_EQ(Next(*device).buttons, 0) << wireless;
  }
}

// Neither is a turn of the grip, nor of the bur.
TEST(Inverse3Test, AGripWhoseNumbersAreNoTurnOrThatIsAwayTurnsNothing) {
  EmulatedInverse3 service;
  auto bus = OpenInverse3({service.address(), 1, 0.1});
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  const auto hear = [&] {
    PolledBus::Pose pose;
    EXPECT_TRUE((*bus)->Send(dvec3(0)));
    return (*bus)->Read(pose);
  };
  // Longer than an answer that is under way.
  const auto hears = [&](PolledBus::Heard wanted) {
    for (int i = 0; i < 1'000; ++i) {
      if (hear() == wanted) return true;
    }
    return false;
  };
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const std::array<double, 4>& q : {std::array<double, 4>{0, 0, 0, 0},
                                         {1e300, 0, 0, 1e300},
                                         {kInfinite, 0, 0, 0},
                                         {0, 0, 0, 0.5}}) {
    service.Grip(q, false, false);
    EXPECT_TRUE(hears(PolledBus::Heard::kRefused)) << q[0] << " " << q[3];
    service.Grip({0, 0, 0, 1}, false, false);
    EXPECT_TRUE(hears(PolledBus::Heard::kPose));
  }
  service.HasGrip(false);
  EXPECT_TRUE(hears(PolledBus::Heard::kRefused));
}

TEST(Inverse3Test, WithoutAGripItNeedsAFootPedal) {
  EmulatedInverse3 service;
  service.HasGrip(false);
  const auto listed = FindInverse3At(service.address());
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].problem.field(), trouble::kNoGrip);
  EXPECT_NE(listed[0].problem.message().find("connect the VerseGrip"), std::string::npos);
  BusChoice choice{service.address(), 1, 0.1};
  EXPECT_EQ(OpenInverse3(choice).status().field(), trouble::kNoGrip);
  choice.has_pedal = true;
  auto bus = OpenInverse3(choice);
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  // A grip that is connected later would turn the bur at once.
  service.HasGrip(true);
  service.Grip({0, 0, 0, 1}, true, false);
  for (int i = 0; i < 20; ++i) {
    PolledBus::Pose pose;
    EXPECT_TRUE((*bus)->Send(dvec3(0)));
    if ((*bus)->Read(pose) != PolledBus::Heard::kPose) continue;
    EXPECT_EQ(pose.orientation.w, 1);
    EXPECT_FALSE(pose.pedal);
  }
}

TEST(Inverse3Test, AGripThatSomebodyBuiltTurnsTheBur) {
  EmulatedInverse3 service;
  service.HasBuiltGrip();
  service.Grip({0, 0, 0, 1}, true, false);
  EXPECT_TRUE(FindInverse3At(service.address())[0].problem.ok());
  auto device = MustOpen(service);
  const DeviceSample s = Next(*device);
  EXPECT_NEAR((FromQuantised(s.orientation).Matrix() * dvec3(0, 0, -1)).y, 1, 1e-3);
  EXPECT_EQ(s.buttons, kPedal);
}

// The service and its force are not to blame.
TEST(Inverse3Test, AGripWithoutAnOrientationIsNamedWhenItIsOpened) {
  EmulatedInverse3 service;
  service.Grip({0, 0, 0, 0}, false, true);
  const Status refused = OpenInverse3({service.address(), 1, 0.1}).status();
  EXPECT_EQ(refused.field(), trouble::kNoGrip) << refused.message();
  EXPECT_NE(refused.message().find("wake it"), std::string::npos) << refused.message();
}

TEST(Inverse3Test, ItsModelChoosesTheProfileAndAnothersForceIsRefused) {
  EmulatedInverse3 service;
  for (const auto& [type, name] : {std::pair{"inverse3", "Inverse3 049D"},
                                   {"inverse3x", "Inverse3x 049D"},
                                   {"minverse", "MinVerse 049D"}}) {
    service.IsOf(type);
    const auto listed = FindInverse3At(service.address());
    ASSERT_EQ(listed.size(), 1u);
    EXPECT_EQ(listed[0].profile, type);
    EXPECT_EQ(listed[0].name, name);
    EXPECT_TRUE(listed[0].problem.ok()) << listed[0].problem.message();
  }
  // A MinVerse now. A school's own profile may have any name.
  for (const auto& [profile, is_taken] :
       {std::pair{"inverse3", false}, {"minverse", true}, {"room_4", true}}) {
    BusChoice choice{service.address(), 1, 0.1};
    choice.profile = profile;
    const Status opened = OpenInverse3(choice).status();
    EXPECT_EQ(opened.ok(), is_taken) << opened.message();
    if (!is_taken) EXPECT_EQ(opened.field(), trouble::kModel) << opened.message();
  }
  EXPECT_LT(scene::FindProfile("minverse")->peak_force_mn.value,
            scene::FindProfile("inverse3")->peak_force_mn.value);
  for (const auto& [type, field] :
       {std::pair{"inverse9", trouble::kModel}, {"", trouble::kService}}) {
    service.IsOf(type);
    const auto listed = FindInverse3At(service.address());
    ASSERT_EQ(listed.size(), 1u);
    EXPECT_EQ(listed[0].profile, "");
    EXPECT_EQ(listed[0].problem.field(), field) << listed[0].problem.message();
    EXPECT_EQ(OpenInverse3({service.address(), 1, 0.1}).status().field(), field);
  }
}

// Pings without end, which a client answers before it sees a message; and text that is none of the service's.
TEST(Inverse3Test, AServiceThatSendsWithoutEndIsRefusedInTime) {
  EmulatedInverse3 service;
  Bytes pings;
  for (int i = 0; i < 500; ++i) pings.insert(pings.end(), {0x89, 0x00});
  for (const Bytes& bytes : {pings, Bytes{0x81, 0x01, 'x'}}) {
    service.Babble(bytes);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(OpenInverse3({service.address(), 1, 0.1}).status().field(), trouble::kService);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
  }
}

TEST(SerialArmTest, APortThatSendsWithoutEndIsRefusedInTime) {
  const Status refused = OpenPolhemSerial({"/dev/zero", 5, 0.15}).status();
  EXPECT_EQ(refused.field(), trouble::kSilent) << refused.message();
}

// Reports of the right size, more than anybody asked for: the next one may be old.
TEST(HidArmTest, OneThatSendsWithoutEndIsRefusedInTimeAndLeftWithForceZero) {
  HidBus::Get().Reset();
  const test::TempFolder folder;
  testing_support::ScriptedHid arm;
  arm.path = (folder.path() / "hidraw").string();
  std::ofstream(arm.path).put('\n');  // one that may be opened
  arm.vendor = 0x1234;
  arm.product = 0x0006;
  arm.answer = [](ByteView) { return Bytes(8); };
  HidBus::Get().Plug(arm);
  auto bus = OpenWoodenHaptics({"", 5, 0.3});
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  ASSERT_TRUE((*bus)->Send(dvec3(0, 0, 1)));
  EXPECT_NE(HidBus::Get().Written().back(), Bytes(9));
  arm.endless = Bytes(8);
  HidBus::Get().Plug(arm);
  EXPECT_FALSE((*bus)->Send(dvec3(0, 0, 1)));
  EXPECT_EQ(HidBus::Get().Written().back(), Bytes(9));
  EXPECT_EQ(OpenWoodenHaptics({"", 5, 0.3}).status().code(), Code::kUnavailable);
  bus->reset();
  HidBus::Get().Reset();
}

TEST(Inverse3Test, OneThatCannotBeUsedIsRefusedAndListedWithWhatToDo) {
  const std::pair<std::function<void(EmulatedInverse3&)>, const char*> kReasons[] = {
      {[](EmulatedInverse3& s) { s.Status("calibrated", false); }, "inkwell"},
      {[](EmulatedInverse3& s) { s.Status("power_supply", false); }, "connect its power supply"},
      {[](EmulatedInverse3& s) { s.Status("ready", false); }, "not ready"},
      {[](EmulatedInverse3& s) { s.Damp(0.5); }, "filters.damping"}};
  for (const auto& [spoil, expected] : kReasons) {
    EmulatedInverse3 service;
    spoil(service);
    const Status refused = Open(service).status();
    EXPECT_EQ(refused.code(), Code::kUnavailable);
    EXPECT_NE(refused.message().find(expected), std::string::npos) << refused.message();
    const auto listed = FindInverse3At(service.address());
    ASSERT_EQ(listed.size(), 1u);
    EXPECT_NE(listed[0].problem.message().find(expected), std::string::npos);
    EXPECT_EQ(listed[0].problem.field(), refused.field());
    EXPECT_NE(refused.field(), trouble::kDevice) << refused.message();
  }
}

TEST(Inverse3Test, ItIsListedWithItsIdAndProfileAndNothingIsStarted) {
  EmulatedInverse3 service;
  const auto listed = FindInverse3At(service.address());
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].name, "Inverse3 049D");
  EXPECT_EQ(listed[0].unit, "inverse3:049D");
  EXPECT_TRUE(scene::FindProfile(listed[0].profile).ok());
  EXPECT_TRUE(listed[0].problem.ok()) << listed[0].problem.message();
  EXPECT_EQ(service.requests(), 0u);
  service.Disconnect();
  EXPECT_TRUE(FindInverse3At(service.address()).empty());
  EXPECT_EQ(Open(service).status().code(), Code::kNotFound);
}

TEST(Inverse3Test, AServiceThatRestartsOrADeviceWithoutPowerOrCalibrationCountsAsUnplugged) {
  const std::function<void(EmulatedInverse3&)> kEnds[] = {
      [](EmulatedInverse3& s) { s.Restart(); }, [](EmulatedInverse3& s) { s.Disconnect(); },
      [](EmulatedInverse3& s) { s.Status("power_supply", false); },
      [](EmulatedInverse3& s) { s.Status("calibrated", false); }};
  for (const auto& end : kEnds) {
    EmulatedInverse3 service;
    auto device = MustOpen(service);
    end(service);
    test::AwaitSample(*device, [](const DeviceSample& s) { return !s.attached; });
  }
}

TEST(Inverse3Test, ItComesBackAlsoWhereAnotherIsListedFirstByThen) {
  EmulatedInverse3 service;
  auto device = MustOpen(service);
  service.SwitchOff();
  test::AwaitSample(*device, [](const DeviceSample& s) { return !s.attached; });
  service.ListOtherFirst();
  service.SwitchOn();
  test::AwaitSample(*device, [](const DeviceSample& s) { return s.attached && s.fresh; });
}

TEST(Inverse3Test, AnswersThatAreNoJsonMoveNothing) {
  EmulatedInverse3 service;
  auto device = MustOpen(service);
  service.Truncate(true);
  AwaitThat([&] { return device->counters().refused >= 5; });
  EXPECT_TRUE(device->ReadSample().attached);
  service.Truncate(false);
  Next(*device);
}

TEST(Inverse3Test, WithoutTheServiceItsAddressIsNamed) {
  EmulatedInverse3 service;
  service.Unplug();
  const Status refused = Open(service).status();
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find(service.address()), std::string::npos) << refused.message();
}

TEST(Inverse3Test, EachQuestionHasOneAnswer) {
  EmulatedInverse3 service;
  auto bus = OpenInverse3({service.address(), 1, 0.1});
  ASSERT_TRUE(bus.ok()) << bus.status().message();
  const uint64_t before = service.requests();
  for (int i = 0; i < 200; ++i) {
    PolledBus::Pose pose;
    ASSERT_TRUE((*bus)->Send(dvec3(0)));
    (void)(*bus)->Read(pose);
  }
  AwaitThat([&] { return service.requests() >= before + 200; });
  EXPECT_EQ(service.requests(), before + 200);
}

}  // namespace
}  // namespace enamel::station::sdk
