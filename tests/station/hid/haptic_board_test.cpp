#include "station/hid/haptic_board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <functional>
#include <limits>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "station/hid/open_device.h"
#include "station/loop/tick_loop.h"
#include "tests/station/hid/hid_double.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/await_sample.h"
#include "tests/support/block_plan.h"
#include "tests/support/opens_with.h"

namespace enamel::station::hid {
namespace {

using testing_support::HidBus;
using testing_support::ScriptedHid;

constexpr const char* kPath = "/dev/hidraw4";

FeatureReport Feature(uint32_t resolution_nm = 10'000) {
  FeatureReport f;
  f.resolution_nm.fill(resolution_nm);
  f.peak_force_mn.fill(7'900);
  f.max_watchdog_ms = 100;
  f.rate_hz = 1000;
  f.name = "Bench arm";
  f.profile = "phantom_desktop";
  return f;
}

ScriptedHid Plugged(const FeatureReport& feature = Feature()) {
  ScriptedHid d;
  d.path = kPath;
  d.vendor = 0x1209;
  d.product = 0x0001;
  d.usage_page = kBoardUsagePage;
  d.usage = kBoardUsage;
  auto bytes = EncodeFeature(feature);
  d.feature.assign(bytes.begin(), bytes.end());
  return d;
}

TEST(ReportOrderTest, CountsWhatIsLostAndLeavesOutWhatIsLateOrDoubled) {
  using V = ReportOrder::Verdict;
  ReportOrder order;
  EXPECT_EQ(order.Judge(5), V::kNew);
  EXPECT_EQ(order.Judge(6), V::kNew);
  EXPECT_EQ(order.Judge(6), V::kDuplicate);
  EXPECT_EQ(order.Judge(10), V::kNew);
  EXPECT_EQ(order.lost(), 3u);
  EXPECT_EQ(order.Judge(9), V::kLate);
  EXPECT_EQ(order.Judge(11), V::kNew);
  EXPECT_EQ(order.lost(), 3u);
}

TEST(ReportOrderTest, WrapsAndNoticesARestart) {
  using V = ReportOrder::Verdict;
  ReportOrder order;
  EXPECT_EQ(order.Judge(UINT32_MAX), V::kNew);
  EXPECT_EQ(order.Judge(0), V::kNew);
  EXPECT_EQ(order.Judge(UINT32_MAX), V::kLate);
  EXPECT_EQ(order.Judge(5000), V::kNew);
  EXPECT_EQ(order.lost(), 4999u);
  EXPECT_EQ(order.Judge(4000), V::kLate);
  EXPECT_EQ(order.Judge(3999), V::kRestarted);
  EXPECT_EQ(order.Judge(4000), V::kNew);
  EXPECT_EQ(order.lost(), 4999u);
}

TEST(AxisMapTest, MapsPosesAndForcesInverselyAndRefusesMirrors) {
  auto map = ParseAxisMap("-y+x+z");
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(map->ToScene(std::array<int32_t, 3>{1, 2, 3}), (std::array<int32_t, 3>{-2, 1, 3}));
  EXPECT_EQ(map->ToScene(std::array<int32_t, 3>{0, INT32_MIN, 0})[0], INT32_MAX);
  EXPECT_EQ(map->ToBoard(dvec3(-2, 1, 3)), dvec3(1, 2, 3));
  // A turn about the board's y is one about the scene's -x: conjugation by the map's rotation.
  Quat turned = map->ToScene(Quat{0, 0.6, 0, 0.8});
  EXPECT_EQ(turned.x, -0.6);
  EXPECT_EQ(turned.w, 0.8);
  for (const char* bad : {"", "+x+y", "+x+y-z", "+x+x+z", "+y+x+z", "xyz+++", "+x+y+w"}) {
    EXPECT_FALSE(ParseAxisMap(bad).ok()) << bad;
  }
}

class HapticBoardTest : public testing::Test {
 protected:
  HapticBoardTest() { bus_.Reset(); }
  ~HapticBoardTest() override {
    bus_.HoldWrites(false);
    board_.reset();
    bus_.Reset();
  }

  // Opens it while another thread plays the board's first report.
  Status Open(HapticBoardSettings settings = {}) {
    std::thread first([&] {
      if (bus_.Await([](HidBus& b) { return b.handle_count() == 3; })) Send(first_);
    });
    auto board = HapticBoard::Open(settings);
    first.join();
    if (!board.ok()) return board.status();
    board_ = std::move(*board);
    return Status::Ok();
  }
  void Send(InputReport report) { bus_.Send(kPath, EncodeInput(report)); }
  InputReport At(uint32_t sequence, int32_t z) {
    InputReport r;
    r.sequence = sequence;
    r.counts = {first_.counts[0], first_.counts[1], z};
    return r;
  }
  DeviceSample Until(const std::function<bool(const DeviceSample&)>& wanted) {
    return test::AwaitSample(*board_, wanted);
  }
  template <typename Reached>
  void UntilCounted(Reached reached) {
    for (int i = 0; i < 10'000 && !reached(board_->counters()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(reached(board_->counters()));
  }
  // Sends a force, and waits until the board's motors were requested.
  bool Drive() {
    board_->SendForce(dvec3(0, 0, 0.5));
    return bus_.Await([](HidBus& b) {
      OutputReport out;
      return std::any_of(b.written().begin(), b.written().end(), [&](const Bytes& bytes) {
        return DecodeOutput(bytes, out) == ReportError::kNone && out.motors_on;
      });
    });
  }
  OutputReport LastWritten() {
    OutputReport out;
    auto all = bus_.Written();
    EXPECT_FALSE(all.empty());
    if (!all.empty()) {
      EXPECT_EQ(DecodeOutput(all.back(), out), ReportError::kNone);
    }
    return out;
  }

  HidBus& bus_ = HidBus::Get();
  InputReport first_ = [] {
    InputReport r;
    r.sequence = 100;
    r.time_us = UINT32_MAX - 500;
    r.counts = {1000, -2000, 3000};
    return r;
  }();
  std::unique_ptr<HapticBoard> board_;
};

TEST_F(HapticBoardTest, CentresOnTheFirstReportAndFollowsTheNext) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(board_->Name(), "Bench arm");
  DeviceSample s = Until([](const DeviceSample& d) { return d.fresh; });
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{0, 0, 0}));
  EXPECT_TRUE(s.attached);
  EXPECT_EQ(s.sequence, 100u);
  InputReport next = At(101, 3007);
  next.time_us = 499;  // wrapped
  next.buttons = 1;
  next.status = kMotorsOn | kOrientationValid;
  next.orientation = {0, 0, 23170, 23170};
  Send(next);
  s = Until([](const DeviceSample& d) { return d.sequence == 101; });
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{0, 0, 7}));
  EXPECT_EQ(s.device_time_us - (UINT32_MAX - 500ull), 1000u);
  EXPECT_EQ(s.buttons, kPedal);
  EXPECT_EQ(s.bur_speed_krpm, kTurbineSpeed_krpm);
  EXPECT_EQ(s.orientation, (QuantisedOrientation{0, 0, 23170, 23170}));
  EXPECT_TRUE(s.fresh);
  EXPECT_FALSE(board_->ReadSample().fresh);  // nothing new: the loop counts it as silence
}

FeatureReport WithSpring() {
  FeatureReport f = Feature();
  f.spring_kc_mn_per_mm = 7'000;
  f.spring_rate_hz = 8'000;
  f.spring_delay_ticks = 1;
  return f;
}

// Scene x is the board's -y, scene y its x; counts of 10 um; the middle is the first report's place.
TEST_F(HapticBoardTest, TheSpringsRestPointIsTurnedAndCentredBothWays) {
  bus_.Plug(Plugged(WithSpring()));
  HapticBoardSettings settings;
  settings.axes = *ParseAxisMap("-y+x+z");
  ASSERT_TRUE(Open(settings).ok());
  EXPECT_TRUE(board_->runs_spring());
  InputReport next = At(101, 3007);
  next.rest_nm = {10'000'300, -20'000'200, 30'000'100};
  next.share = 60'000;
  Send(next);
  const DeviceSample s = Until([](const DeviceSample& d) { return d.sequence == 101; });
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{0, 0, 7}));
  EXPECT_EQ(s.rest_nm, (std::array<int32_t, 3>{200, 300, 100}));
  EXPECT_EQ(s.share, 60'000);
  SpringCommand command;
  command.on = true;
  command.rest_nm = s.rest_nm;
  command.added_n = dvec3(0.1, 0.2, 0.3);
  command.torque_n_m = dvec3(1e-3);
  command.bound_n = 7.9;
  board_->SendSpring(command);
  SpringReport out;
  ASSERT_TRUE(bus_.Await([&](HidBus& b) {
    return !b.written().empty() && DecodeSpring(b.written().back(), out) == ReportError::kNone;
  }));
  EXPECT_EQ(out.rest_nm, next.rest_nm);
  EXPECT_EQ(out.force_100un, (std::array<int16_t, 3>{2000, -1000, 3000}));
  EXPECT_EQ(out.torque_20un_m, (std::array<int16_t, 3>{0, 0, 0})) << "it drives three axes";
  EXPECT_EQ(out.bound_mn, 7'900);
  EXPECT_TRUE(out.motors_on && out.spring_on && !out.follow);
}

TEST_F(HapticBoardTest, ACommandToTheSpringIsWrittenOnceAndAForceTurnsItOff) {
  bus_.Plug(Plugged(WithSpring()));
  ASSERT_TRUE(Open().ok());
  SpringCommand command;
  command.on = true;
  board_->SendSpring(command);
  const auto written = [](HidBus& b) {
    SpringReport out;
    return !b.written().empty() && DecodeSpring(b.written().back(), out) == ReportError::kNone &&
           out.spring_on;
  };
  ASSERT_TRUE(bus_.Await(written));
  const uint64_t writes = board_->counters().writes;
  // Ten repeats of a force; a slow machine can only let this pass.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(board_->counters().writes, writes + 1);
  board_->SendForce(dvec3(0));
  EXPECT_TRUE(bus_.Await([](HidBus& b) {
    OutputReport out;
    return DecodeOutput(b.written().back(), out) == ReportError::kNone && out.motors_on;
  }));
  board_.reset();
  EXPECT_FALSE(LastWritten().motors_on);
}

TEST_F(HapticBoardTest, AProfileThatLeavesTheSpringToTheBoardNeedsThatSpring) {
  scene::DeviceProfile profile = test::PlainProfile();
  EXPECT_TRUE(CheckBoard(WithSpring(), profile, 1000).ok()) << "the station runs its own";
  profile.board_spring = scene::BoardSpringSpec{8'000, 1, "test"};
  profile.coupling_mn_per_mm.value = 7'000;
  EXPECT_TRUE(CheckBoard(WithSpring(), profile, 1000).ok());
  EXPECT_EQ(CheckBoard(Feature(), profile, 1000).field(), "board_spring");
  profile.coupling_mn_per_mm.value = 6'999;
  const Status s = CheckBoard(WithSpring(), profile, 1000);
  EXPECT_EQ(s.code(), Code::kConflict);
  for (const char* said : {"7000 mN/mm at 8000 Hz", "6999 mN/mm at 8000 Hz"})
    EXPECT_NE(s.message().find(said), std::string::npos) << s.message();
}

TEST_F(HapticBoardTest, ShortWrongAndDamagedReportsAreCountedAndChangeNothing) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  auto good = EncodeInput(At(101, 4000));
  auto wrong_id = good, wrong_version = good, damaged = good;
  wrong_id[0] = 0x49;
  wrong_version[1] = 2;
  damaged[20] ^= 0x10;
  bus_.Send(kPath, {good.data(), 47});
  bus_.Send(kPath, {good.data(), 1});
  bus_.Send(kPath, wrong_id);
  bus_.Send(kPath, wrong_version);
  bus_.Send(kPath, damaged);
  UntilCounted([](const DeviceCounters& c) { return c.refused == 5; });
  EXPECT_EQ(board_->ReadSample().sequence, 100u);
  Send(At(102, 3005));
  EXPECT_EQ(Until([](const DeviceSample& d) { return d.sequence == 102; }).counts[2], 5);
  EXPECT_EQ(board_->counters().samples, 2u);
  EXPECT_EQ(board_->counters().lost, 1u);
}

TEST_F(HapticBoardTest, LateAndDoubledReportsNeverMoveTheHandBack) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  Send(At(105, 3050));
  Send(At(104, 3040));
  Send(At(105, 9999));
  UntilCounted([](const DeviceCounters& c) { return c.duplicated == 2; });
  DeviceSample s = board_->ReadSample();
  EXPECT_EQ(s.counts[2], 50);
  EXPECT_EQ(board_->counters().lost, 4u);
}

TEST_F(HapticBoardTest, BoardThatIsNotFitIsAsUnplugged) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  InputReport hot = At(101, 3001);
  hot.status = kNotFit;
  Send(hot);
  EXPECT_FALSE(Until([](const DeviceSample& d) { return d.sequence == 101; }).attached);
  Send(At(102, 3001));
  EXPECT_TRUE(Until([](const DeviceSample& d) { return d.sequence == 102; }).attached);
}

// Scene x is board -y, scene y board x: (0.5, 2.5, -1.23456) N is (2.5, -0.5, -1.23456) N
// there, 2.5 times the peak of 1 N on its first axis: 1/2.5 of all of it.
TEST_F(HapticBoardTest, WritesTheForceInItsOwnAxesAndItsDirectionWithinItsPeak) {
  FeatureReport feature = Feature();
  feature.peak_force_mn = {1'000, 7'900, 7'900};
  bus_.Plug(Plugged(feature));
  HapticBoardSettings settings;
  settings.axes = *ParseAxisMap("-y+x+z");
  settings.watchdog_ms = 500;  // more than the board accepts
  ASSERT_TRUE(Open(settings).ok());
  board_->SendForce(dvec3(0.5, 2.5, -1.23456));
  // Before the first force it is kept alive with the motors off, and soon after it again.
  OutputReport out;
  ASSERT_TRUE(bus_.Await([&](HidBus& b) {
    return std::ranges::any_of(b.written(), [&](const Bytes& report) {
      EXPECT_EQ(report.size(), kOutputBytes);
      return DecodeOutput(report, out) == ReportError::kNone && out.motors_on;
    });
  }));
  EXPECT_TRUE(out.motors_on);
  EXPECT_EQ(out.force_100un, (std::array<int32_t, 3>{10'000, -2'000, -4'938}));
  EXPECT_EQ(out.watchdog_ms, 100);
}

// A torque is turned like a force; a board of three axes gets none.
TEST_F(HapticBoardTest, WritesTheTorqueInItsOwnAxesWhereItDrivesThem) {
  for (uint8_t axes : {uint8_t{6}, uint8_t{3}}) {
    FeatureReport feature = Feature();
    feature.axes = axes;
    bus_.Plug(Plugged(feature));
    HapticBoardSettings settings;
    settings.axes = *ParseAxisMap("-y+x+z");
    ASSERT_TRUE(Open(settings).ok());
    board_->SendForceAndTorque(dvec3(0, 0, 1), dvec3(0.05, 0.1, -0.0123456));
    OutputReport out;
    ASSERT_TRUE(bus_.Await([&](HidBus& b) {
      return std::ranges::any_of(b.written(), [&](const Bytes& report) {
        return DecodeOutput(report, out) == ReportError::kNone && out.motors_on;
      });
    }));
    const std::array<int32_t, 3> turned{100'000, -50'000, -12'346}, none{};
    EXPECT_EQ(out.torque_un_m, axes == 6 ? turned : none);
    // Without the loop it falls with the force.
    ASSERT_TRUE(bus_.Await([](HidBus& b) {
      OutputReport newest;
      return DecodeOutput(b.written().back(), newest) == ReportError::kNone && !newest.motors_on &&
             newest.torque_un_m == std::array<int32_t, 3>{};
    }));
    board_.reset();
    bus_.Reset();
  }
}

TEST_F(HapticBoardTest, StalledWriteHoldsUpNeitherReadingNorTheTickAndIsFollowedByTheNewestForce) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  bus_.HoldWrites(true);
  board_->SendForce(dvec3(0, 0, 1));
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.waiting() == 1; }));
  size_t before = bus_.Written().size();
  // The write is stuck for this long: ten ticks and more.
  size_t allocations = 0;
  for (uint32_t tick = 1; tick <= 50; ++tick) {
    Send(At(100 + tick, 3000 + static_cast<int32_t>(tick)));
    Until([&](const DeviceSample& d) { return d.sequence == 100 + tick && d.attached; });
    enamel::testing_support::AllocationGuard guard;
    board_->ReadSample();
    board_->SendForce(dvec3(0, 0, 0.01 * tick));
    allocations += guard.count();
  }
  EXPECT_EQ(bus_.WritesWaiting(), 1);
  EXPECT_EQ(bus_.Written().size(), before);
  EXPECT_EQ(allocations, 0u);
  bus_.HoldWrites(false);
  ASSERT_TRUE(bus_.Await([&](HidBus& b) { return b.written_count() >= before + 2; }));
  // The stuck force, and then one for the fifty: the last, or on a slow machine its remainder.
  OutputReport next;
  ASSERT_EQ(DecodeOutput(bus_.Written()[before + 1], next), ReportError::kNone);
  EXPECT_LE(next.force_100un[2], 5000);
  EXPECT_NE(next.force_100un[2], 10'000);
}

TEST_F(HapticBoardTest, WithoutNewForcesTheBoardIsKeptAliveAndTheForceIsGone) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  board_->SendForce(dvec3(0, 0, 2));
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.written_count() >= 30; }));
  OutputReport last = LastWritten();
  EXPECT_EQ(last.force_100un, (std::array<int32_t, 3>{0, 0, 0}));
  EXPECT_FALSE(last.motors_on);
  uint32_t expected = 1;
  for (const Bytes& b : bus_.Written()) {
    OutputReport out;
    ASSERT_EQ(DecodeOutput(b, out), ReportError::kNone);
    EXPECT_EQ(out.sequence, expected++);
  }
}

TEST_F(HapticBoardTest, EndsWithMotorsOff) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  board_->SendForce(dvec3(0, 0, 2));
  board_.reset();
  EXPECT_FALSE(LastWritten().motors_on);
  EXPECT_EQ(bus_.OpenHandles(), 0);
}

TEST_F(HapticBoardTest, PluggedInAgainElsewhereItIsBackAndNotMovedByTheWay) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  bus_.Unplug(kPath);
  DeviceSample s = Until([](const DeviceSample& d) { return !d.attached; });
  EXPECT_FALSE(s.fresh);
  EXPECT_EQ(s.buttons, 0);
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
  ScriptedHid again = Plugged();
  again.path = "/dev/hidraw12";
  bus_.Plug(again);
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 2; }));
  InputReport r = At(3, 3020);  // it counts from the start again
  bus_.Send(again.path, EncodeInput(r));
  s = Until([](const DeviceSample& d) { return d.attached; });
  EXPECT_EQ(s.counts[2], 20);
  size_t before = bus_.Written().size();
  board_->SendForce(dvec3(0, 0, 1));
  EXPECT_TRUE(bus_.Await([&](HidBus& b) { return b.written_count() > before; }));
}

TEST_F(HapticBoardTest, AnotherBoardBehindTheSameIdsIsNotTaken) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  bus_.Unplug(kPath);
  Until([](const DeviceSample& d) { return !d.attached; });
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
  // Other cells; another serial number; another peak.
  FeatureReport weaker = Feature();
  weaker.peak_force_mn[2] = 3'300;
  ScriptedHid numbered = Plugged();
  numbered.serial = L"B2";
  for (const ScriptedHid& other : {Plugged(Feature(20'000)), Plugged(weaker), numbered}) {
    int opened = bus_.Opened();
    bus_.Plug(other);
    // Opened twice, and refused each time.
    ASSERT_TRUE(bus_.Await([&](HidBus& b) { return b.opened() >= opened + 2; }));
    Send(At(101, 3001));
    EXPECT_FALSE(board_->ReadSample().attached);
    bus_.Unplug(kPath);
    ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
  }
  EXPECT_EQ(board_->counters().samples, 1u);
  bus_.Plug(Plugged());
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 2; }));
  Send(At(101, 3001));
  Until([](const DeviceSample& d) { return d.attached; });
}

TEST_F(HapticBoardTest, BoardThatDoesNotAnswerYetWhenItIsBackIsAskedAgain) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  bus_.Unplug(kPath);
  Until([](const DeviceSample& d) { return !d.attached; });
  ScriptedHid booting = Plugged();
  booting.feature.clear();
  int opened = bus_.Opened();
  bus_.Plug(booting);
  ASSERT_TRUE(bus_.Await([&](HidBus& b) { return b.opened() >= opened + 2; }));
  bus_.Plug(Plugged());
  // It reports all the time, as a board does: handles of a try that asked before it answered, and failed,
  // may still be open, and what these hear is lost.
  uint32_t sequence = 6;
  const DeviceSample back = Until([&](const DeviceSample& d) {
    Send(At(++sequence, 3004));
    return d.attached;
  });
  EXPECT_EQ(back.counts[2], 4);
}

TEST_F(HapticBoardTest, NotFitForOneReportBetweenTwoTicksIsSeenByTheTick) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  board_->ReadSample();
  InputReport hot = At(101, 3001);
  hot.status = kNotFit;
  Send(hot);
  Send(At(102, 3001));
  UntilCounted([](const DeviceCounters& c) { return c.samples == 3; });
  DeviceSample seen = board_->ReadSample();
  EXPECT_EQ(seen.sequence, 102u);
  EXPECT_FALSE(seen.attached);
  EXPECT_FALSE(seen.fresh);
  EXPECT_TRUE(board_->ReadSample().attached);
}

TEST_F(HapticBoardTest, ItsClockWrapsAndNeverGoesBackWhenItRestarts) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  const uint64_t begin = board_->ReadSample().device_time_us;
  uint32_t sequence = 100;
  uint64_t passed = 0;
  auto at = [&](uint32_t time_us) {
    InputReport r = At(++sequence, 3000);
    r.time_us = time_us;
    Send(r);
    return Until([&](const DeviceSample& d) { return d.sequence == sequence; }).device_time_us -
           begin;
  };
  // Half an hour at a step, several times around.
  for (int i = 1; i <= 8; ++i) {
    passed += 1'800'000'000;
    EXPECT_EQ(at(static_cast<uint32_t>(first_.time_us + passed)), passed);
  }
  sequence = 4'000'000'000;  // back by more than a thousand: restarted, its clock at 5 s
  EXPECT_EQ(at(5'000'000), passed);
  EXPECT_EQ(at(5'001'000), passed + 1000);
}

TEST_F(HapticBoardTest, HandpieceInItsHolderIsPutDownAndEndsNothing) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  InputReport lying = At(101, 3001);
  lying.buttons = 2;
  Send(lying);
  EXPECT_EQ(Until([](const DeviceSample& d) { return d.sequence == 101; }).buttons, kPutDown);
  InputReport second = At(102, 4001);
  second.buttons = 4;
  Send(second);
  EXPECT_EQ(Until([](const DeviceSample& d) { return d.sequence == 102; }).buttons, kSecond);
}

TEST_F(HapticBoardTest, OrientationThatIsNoTurnLeavesTheToolAsItIs) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  InputReport turned = At(101, 3001);
  turned.status = kOrientationValid;
  turned.orientation = {0, 0, 23170, 23170};
  Send(turned);
  InputReport none = At(102, 3001);
  none.status = kOrientationValid;
  none.orientation = {0, 0, 0, 0};
  Send(none);
  DeviceSample s = Until([](const DeviceSample& d) { return d.sequence == 102; });
  EXPECT_EQ(s.orientation, (QuantisedOrientation{0, 0, 23170, 23170}));
}

TEST_F(HapticBoardTest, WhatCannotBeOpenedSaysWhy) {
  auto refusal = [] { return HapticBoard::Open({}).status(); };
  EXPECT_EQ(refusal().code(), Code::kNotFound);
  ScriptedHid d = Plugged();
  d.may_open = false;
  bus_.Plug(d);
  const test::OpensWith call([](const char*, int) {
    errno = EACCES;
    return -1;
  });
  Status s = refusal();
  EXPECT_EQ(s.code(), Code::kUnavailable);
  EXPECT_NE(s.message().find("60-enamel.rules"), std::string::npos);
  d = Plugged();
  d.feature.clear();
  bus_.Plug(d);
  EXPECT_NE(refusal().message().find("does not answer"), std::string::npos);
  d = Plugged();
  d.feature[1] = 9;
  bus_.Plug(d);
  EXPECT_EQ(refusal().code(), Code::kVersion);
  d = Plugged();
  d.feature[4] ^= 1;
  bus_.Plug(d);
  EXPECT_NE(refusal().message().find("checksum"), std::string::npos);
}

TEST_F(HapticBoardTest, SilentBoardIsRefused) {
  bus_.Plug(Plugged());
  auto board = HapticBoard::Open({});
  ASSERT_FALSE(board.ok());
  EXPECT_NE(board.status().message().find("no pose"), std::string::npos);
}

TEST_F(HapticBoardTest, BoardThatIsTooSlowOrTooWeakForTheExerciseIsRefusedWithBothFigures) {
  const scene::DeviceProfile profile = test::PlainProfile();
  FeatureReport board = Feature();
  for (auto [has, needs] :
       {std::pair{100, 500}, {250, 1000}, {499, 500}, {999, 1000}, {4000, 8000}}) {
    board.rate_hz = static_cast<uint16_t>(has);
    Status s = CheckBoard(board, profile, static_cast<uint32_t>(needs));
    EXPECT_EQ(s.code(), Code::kConflict);
    EXPECT_NE(s.message().find(std::to_string(has) + " times"), std::string::npos) << s.message();
    EXPECT_NE(s.message().find(std::to_string(needs) + " times"), std::string::npos);
    EXPECT_TRUE(CheckBoard(board, profile, static_cast<uint32_t>(has)).ok());
  }
  board = Feature();
  board.peak_force_mn[2] = 7'899;
  Status s = CheckBoard(board, profile, 1000);
  EXPECT_EQ(s.code(), Code::kConflict);
  EXPECT_NE(s.message().find("7899"), std::string::npos) << s.message();
  EXPECT_NE(s.message().find("7900"), std::string::npos);
  board.peak_force_mn[2] = 20'000;
  EXPECT_TRUE(CheckBoard(board, profile, 1000).ok());
}

TEST_F(HapticBoardTest, ABoardThatReportsTooSeldomForTheExerciseIsNotOpenedForIt) {
  FeatureReport slow = Feature();
  slow.rate_hz = 250;
  bus_.Plug(Plugged(slow));
  std::thread first([&] {
    if (bus_.Await([](HidBus& b) { return b.handle_count() == 3; })) Send(first_);
  });
  DeviceChoice choice;
  choice.device = "hid";
  auto device = OpenDevice(choice, test::PlainProfile(), 1e-3);
  first.join();
  ASSERT_FALSE(device.ok());
  EXPECT_NE(device.status().message().find("250 times"), std::string::npos);
  EXPECT_NE(device.status().message().find("1000 times"), std::string::npos);
}

// A watchdog report from before it was driven is not news.
TEST_F(HapticBoardTest, AWatchdogThatTripsWhileItIsDrivenIsASwitchOffAndOneFromBeforeIsNone) {
  bus_.Plug(Plugged());
  first_.status = kWatchdogTripped;
  ASSERT_TRUE(Open().ok());
  EXPECT_TRUE(Until([](const DeviceSample& d) { return d.sequence == 100; }).driven);
  ASSERT_TRUE(Drive());
  Send(At(102, 3001));
  EXPECT_TRUE(Until([](const DeviceSample& d) { return d.sequence == 102; }).driven);
  // For only one report between two ticks: still seen.
  InputReport tripped = At(103, 3001);
  tripped.status = kWatchdogTripped;
  Send(tripped);
  Send(At(104, 3001));
  UntilCounted([](const DeviceCounters& c) { return c.samples == 4; });
  DeviceSample seen = board_->ReadSample();
  EXPECT_EQ(seen.sequence, 104u);
  EXPECT_FALSE(seen.driven);
  EXPECT_TRUE(seen.attached);
  EXPECT_TRUE(board_->ReadSample().driven);
}

TEST_F(HapticBoardTest, AWatchdogThatNeverClearsIsASwitchOffSoonAfterTheFirstForce) {
  bus_.Plug(Plugged());
  first_.status = kWatchdogTripped;
  ASSERT_TRUE(Open().ok());
  bool driven = true;
  for (uint32_t i = 1; i <= 2'000 && driven; ++i) {
    board_->SendForce(dvec3(0, 0, 0.5));
    InputReport r = At(100 + i, 3000);
    r.status = kWatchdogTripped;
    Send(r);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    driven = board_->ReadSample().driven;
  }
  EXPECT_FALSE(driven);
}

TEST_F(HapticBoardTest, MotorsThatGoOffByThemselvesAreASwitchOffWhileItLasts) {
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  ASSERT_TRUE(Drive());
  auto driven = [&](uint32_t sequence, uint8_t status) {
    board_->SendForce(dvec3(0, 0, 0.5));
    InputReport r = At(sequence, 3000);
    r.status = status;
    Send(r);
    return Until([&](const DeviceSample& d) { return d.sequence == sequence; }).driven;
  };
  EXPECT_TRUE(driven(101, 0));  // it has not taken effect yet
  // If this thread is held up for 20 ms, the keeper itself switches the motors off, so the test
  // tries again.
  bool seen = false;
  for (uint32_t sequence = 102; !seen && sequence < 200; sequence += 3) {
    EXPECT_TRUE(driven(sequence, kMotorsOn));
    seen = !driven(sequence + 1, 0) && !driven(sequence + 2, 0);
  }
  EXPECT_TRUE(seen);
  EXPECT_TRUE(driven(500, kMotorsOn));
}

TEST_F(HapticBoardTest, ProfileMustHaveTheBoardsCells) {
  const scene::DeviceProfile profile = test::PlainProfile();
  EXPECT_TRUE(CheckBoard(Feature(10'000), profile, 1000).ok());
  Status s = CheckBoard(Feature(20'000), profile, 1000);
  EXPECT_EQ(s.code(), Code::kConflict);
  EXPECT_NE(s.message().find("20000"), std::string::npos);
  EXPECT_NE(s.message().find("10000"), std::string::npos);
  // An arm that counts at its joints is recorded finer than it counts.
  scene::DeviceProfile arm = profile;
  arm.cell = scene::CellSpec{true, 500, 0, "test"};
  EXPECT_TRUE(CheckBoard(Feature(500), arm, 1000).ok());
  EXPECT_EQ(CheckBoard(Feature(10'000), arm, 1000).code(), Code::kConflict);
}

TEST_F(HapticBoardTest, AProfileWithTorqueNeedsABoardThatDrivesSixAxesAndSaysHowItIsTurned) {
  scene::DeviceProfile profile = test::PlainProfile();
  profile.torque.emplace();
  FeatureReport board = Feature(10'000);
  board.axes = 3;
  board.tells_orientation = true;
  Status s = CheckBoard(board, profile, 1000);
  EXPECT_EQ(s.code(), Code::kConflict);
  EXPECT_NE(s.message().find("drives 3 axes"), std::string::npos) << s.message();
  board.axes = 6;
  EXPECT_TRUE(CheckBoard(board, profile, 1000).ok());
  board.tells_orientation = false;
  EXPECT_EQ(CheckBoard(board, profile, 1000).field(), "axes");
}

// The whole chain: a board cutting the block, unplugged between reading and sending.
TEST_F(HapticBoardTest, UnpluggedMidCutIsCommandedZeroWithinTwoTicksOfBeingSeen) {
  test::BlockPlan block = test::MakeBlockPlan();
  const int32_t start = block.CountsAbove(300'000);
  bus_.Plug(Plugged());
  HapticBoardSettings settings;
  settings.centre_on_first_report = false;
  first_.counts = {0, 0, start};
  ASSERT_TRUE(Open(settings).ok());
  core::Core core(block.params, block.volume);
  SampleRing ring(4);
  TickLoop loop(*board_, core, ring, {1000, false, true});
  uint32_t sequence = 100;
  Sample recorded;
  auto tick = [&](int32_t z) {
    InputReport r;
    r.sequence = ++sequence;
    r.counts = {0, 0, z};
    r.buttons = 1;
    uint64_t before = board_->counters().samples;
    Send(r);
    UntilCounted([&](const DeviceCounters& c) { return c.samples > before; });
    loop.Tick();
    ASSERT_TRUE(ring.Pop(recorded));
  };
  // Still for the tenth of a second that it requires, then down.
  for (int i = 0; i < 110; ++i) tick(start);
  for (int i = 1; i < 120 && recorded.tick.witness.force_sent_mn[2] < 200; ++i) tick(start - i);
  ASSERT_GE(recorded.tick.witness.force_sent_mn[2], 200);
  bus_.Unplug(kPath);
  UntilCounted([](const DeviceCounters& c) { return c.detached == 1; });
  ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() <= 1; }));
  loop.Tick();
  loop.Tick();
  while (ring.Pop(recorded)) {
  }
  EXPECT_EQ(recorded.tick.witness.force_sent_mn, (std::array<int32_t, 3>{0, 0, 0}));
  EXPECT_TRUE(recorded.tick.input.flags & core::kFaulted);
  EXPECT_EQ(loop.fault(), Fault::kUnplugged);
}

// In contact with a wall; the board's watchdog trips, and clears again.
TEST_F(HapticBoardTest, AfterItsWatchdogTrippedInContactThereIsNoForceUntilFreeAir) {
  test::BlockPlan block = test::MakeBlockPlan();
  bus_.Plug(Plugged());
  HapticBoardSettings settings;
  settings.centre_on_first_report = false;
  first_.counts = {0, 0, block.CountsAbove(300'000)};
  ASSERT_TRUE(Open(settings).ok());
  core::Core core(block.params, block.volume);
  SampleRing ring(4);
  TickLoop loop(*board_, core, ring, {1000, false, true});
  uint32_t sequence = 100;
  Sample recorded;
  auto tick = [&](int32_t z, uint8_t status, uint8_t buttons = 0) {
    InputReport r;
    r.sequence = ++sequence;
    r.counts = {0, 0, z};
    r.status = status;
    r.buttons = buttons;
    uint64_t before = board_->counters().samples, written = board_->counters().writes;
    Send(r);
    UntilCounted([&](const DeviceCounters& c) { return c.samples > before; });
    loop.Tick();
    ASSERT_TRUE(ring.Pop(recorded));
    UntilCounted([&](const DeviceCounters& c) { return c.writes > written; });
  };
  auto force = [&] { return recorded.tick.witness.force_sent_mn[2]; };
  for (int i = 0; i < 110; ++i) tick(block.CountsAbove(300'000), kMotorsOn);
  int32_t z = block.CountsAbove(300'000);
  while (z > block.CountsAbove(300'000) - 120 && force() < 500) tick(--z, kMotorsOn);
  ASSERT_GE(force(), 500);
  for (int i = 0; i < 10; ++i) {
    tick(z, kWatchdogTripped);
    ASSERT_EQ(force(), 0);
    ASSERT_EQ(loop.fault(), Fault::kSwitchedOff);
  }
  for (int i = 0; i < 300; ++i) {
    tick(z, kMotorsOn);
    ASSERT_EQ(force(), 0);
  }
  EXPECT_EQ(loop.fault(), Fault::kNone);
  for (int i = 0; i < 20; ++i) {
    tick(z, kMotorsOn, 1);
    ASSERT_EQ(force(), 0) << "still in the tooth";
  }
}

TEST_F(HapticBoardTest, RecorderThatStallsCostsTheForceAndNeverTheBoard) {
  test::BlockPlan block = test::MakeBlockPlan();
  bus_.Plug(Plugged());
  ASSERT_TRUE(Open().ok());
  core::Core core(block.params, block.volume);
  SampleRing ring(4);  // and nobody empties it
  TickLoop loop(*board_, core, ring, {1000, false, true});
  size_t allocations = 0;
  for (uint32_t tick = 1; tick <= 60; ++tick) {
    uint64_t before = board_->counters().samples;
    Send(At(100 + tick, 3000 + static_cast<int32_t>(tick)));
    UntilCounted([&](const DeviceCounters& c) { return c.samples > before; });
    enamel::testing_support::AllocationGuard guard;
    loop.Tick();
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_EQ(core.ticks(), 4u);
  EXPECT_EQ(loop.fault(), Fault::kNone);
  EXPECT_EQ(board_->counters().samples, 61u);
  EXPECT_EQ(board_->counters().lost, 0u);
  for (const Bytes& b : bus_.Written()) {
    OutputReport out;
    ASSERT_EQ(DecodeOutput(b, out), ReportError::kNone);
    EXPECT_EQ(out.force_100un, (std::array<int32_t, 3>{0, 0, 0}));
  }
  Sample s;
  while (ring.Pop(s)) {
  }
  Send(At(200, 3100));
  UntilCounted([](const DeviceCounters& c) { return c.samples == 62; });
  loop.Tick();
  ASSERT_TRUE(ring.Pop(s));
  EXPECT_EQ(s.tick.input.gap_ticks, 56u);
}

}  // namespace
}  // namespace enamel::station::hid
