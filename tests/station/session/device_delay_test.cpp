#include "station/session/device_delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <tuple>

#include "common/base/file.h"
#include "common/haptics/coupling.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/plan.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/session/log_lines.h"
#include "tests/support/dice.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

class Attached : public Device {
 public:
  explicit Attached(bool motors, std::string unit = "hid:1209:0001:SN7")
      : motors_(motors), unit_(std::move(unit)) {}
  std::string Name() const override { return "arm"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  std::string Unit() const override { return unit_; }
  bool has_motors() const noexcept override { return motors_; }
  DeviceSample ReadSample() noexcept override { return {}; }
  void SendForce(const dvec3&) noexcept override {}

 private:
  const bool motors_;
  const std::string unit_;
};

// Sends its poses by itself, one each period, by the clock: no thread of its own can be late.
class Paced final : public Attached {
 public:
  explicit Paced(std::chrono::microseconds period) : Attached(true), period_(period) {}
  DeviceCounters counters() const noexcept override {
    DeviceCounters out;
    const auto passed = std::chrono::steady_clock::now() - began_;
    out.samples = 1 + static_cast<uint64_t>(passed / period_);
    return out;
  }

 private:
  const std::chrono::microseconds period_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

// Tissue whose hardness its test switches on and off.
class Fickle final : public haptics::Material {
 public:
  haptics::Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    haptics::Contact contact;
    contact.engaged = is_solid;
    if (is_solid) contact.damping_n_s_per_m = Sym3::Isotropic(1e9);
    return contact;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

  bool is_solid = false;
};

// The most energy, J, that a hand draws from the coupling of these parameters in a loop of the rate that they
// say, if a pose comes only in each n-th tick. In the theorem's own sum (common/haptics/README.md), kept
// here: damping b and the cell's friction pay, and what the spring may hold at the start is free.
double Drawn_j(const core::CoreParams& p, double b_n_s_per_m, int n, uint64_t seed) {
  haptics::CouplingParams c;
  c.law.kind = p.law;
  c.law.kc_n_per_m = p.kc_mn_per_mm;
  c.law.resolution_m = dvec3(p.resolution_nm[0], p.resolution_nm[1], p.resolution_nm[2]) * 1e-9;
  c.law.tick_s = 1.0 / p.rate_hz;
  c.peak_force_n = p.peak_force_mn * 1e-3;
  c.cell = core::TipCellOf(p);
  c.delay_ticks = static_cast<int>(p.bus_delay_ticks);
  haptics::Coupling coupling(c);
  Fickle tissue;
  testing_support::Dice dice(seed);
  const double count_m = p.resolution_nm[0] * 1e-9;
  const auto read = [&](const dvec3& x) { return (glm::floor(x / count_m) + 0.5) * count_m; };
  const double swing_m = 3e-6 * std::pow(10, 2 * dice.Uniform());
  const double period = n * (2 + 12 * dice.Uniform()), hardens = n * (2 + 12 * dice.Uniform());
  const dvec3 along = dice.Direction();
  const int hand = dice.Below(3);
  const bool always_solid = dice.Below(2) == 0;
  dvec3 x(0), pose = read(x), force(0);
  coupling.Reset(pose);
  double balance_j = 0.5 * c.law.kc_n_per_m * Dot(x - pose, x - pose), lowest_j = 0;
  for (int k = 0; k < 1000; ++k) {
    if (k % n == 0) pose = read(x);
    tissue.is_solid = always_solid || std::sin(2 * M_PI * k / hardens) > -0.7;
    force = coupling.Tick(pose, 1, tissue).force_sent_n;
    dvec3 next = along * (swing_m * std::sin(2 * M_PI * (k + 1) / period));
    if (hand == 1) next = x + dice.Direction() * (swing_m * dice.Uniform());
    if (hand == 2)
      next = x + force * (swing_m * dice.Uniform() / std::max(1e-9, glm::length(force)));
    const dvec3 way = next - x;
    balance_j += -Dot(force, way) + b_n_s_per_m / c.law.tick_s * Dot(way, way) +
                 c.law.kc_n_per_m * c.cell.Support(way);
    lowest_j = std::min(lowest_j, balance_j);
    x = next;
  }
  return -lowest_j;
}

class DeviceDelayTest : public testing::Test {
 protected:
  DeviceDelayTest() {
    auto built = scene::BuildBuiltinScene("block", 200'000);
    EXPECT_TRUE(built.ok());
    prepared_.scene = built->scene;
    prepared_.exercise = scene::ClassOneExercise(built->scene, {});
    prepared_.profile = scene::BuiltinProfiles()[1];
    prepared_.volume = std::move(built->volume);
    prepared_.header.params =
        *scene::CompilePlan(prepared_.scene, prepared_.exercise, prepared_.profile);
  }

  void Keep(const std::string& unit, int64_t ticks,
            std::optional<scene::Measured> friction_mn = std::nullopt) {
    scene::Calibration c;
    c.device = unit;
    c.profile = "phantom_desktop";
    c.software = "test";
    c.method = "test";
    c.bus_delay_ticks = scene::Measured{ticks, 0, 8};
    c.friction_mn = friction_mn;
    fs::create_directories(CalibrationsFolder(folder_));
    ASSERT_TRUE(WriteFileDurably(CalibrationFile(folder_, unit), AsBytes(scene::ToJson(c))).ok());
  }
  Status UseDelay(const Device& device) {
    return UseDelayOf(prepared_, device, AwaitPace(device), folder_);
  }
  int32_t Kc() const { return prepared_.header.params.kc_mn_per_mm; }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  PreparedAttempt prepared_;
};

// b = 1.75 N s/m, 1 kHz: 2 b f/4 = 875 mN/mm.
TEST_F(DeviceDelayTest, AnUnmeasuredDeviceIsComputedWithATickAndItIsSaid) {
  LogLines log;
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 875);
  ASSERT_TRUE(prepared_.delay.has_value());
  EXPECT_EQ(*prepared_.delay, (scene::DelayUsed{1, scene::DelayUsed::From::kAssumed, {}}));
  EXPECT_TRUE(log.Has("warning: arm: its delay was never measured")) << log.text();
  EXPECT_TRUE(log.Has("enamel-station calibrate")) << log.text();
  EXPECT_TRUE(log.Has("Kc 875 mN/mm instead of the profile's 2500")) << log.text();
  // The value sent to a server passes its check.
  EXPECT_TRUE(scene::CheckParams(prepared_.scene, prepared_.exercise, prepared_.profile,
                                 prepared_.header.params)
                  .ok());
}

TEST_F(DeviceDelayTest, WhatHasNoMotorsKeepsItsProfile) {
  ASSERT_TRUE(UseDelay(Attached(false)).ok());
  EXPECT_EQ(Kc(), 2500);
  EXPECT_FALSE(prepared_.delay.has_value());
}

TEST_F(DeviceDelayTest, AMeasurementOfThisUnitLiftsItAndOneOfAnotherDoesNot) {
  Keep("hid:1209:0001:SN8", 0);
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 875);
  Keep("hid:1209:0001:SN7", 0);
  LogLines log;
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 2500);
  EXPECT_FALSE(log.Has("warning")) << log.text();
  // A unit without a distinct name never matches a measured one.
  ASSERT_TRUE(UseDelay(Attached(true, "")).ok());
  EXPECT_EQ(Kc(), 875);
  Keep("hid:1209:0001:SN7", 2);
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 388);
}

TEST_F(DeviceDelayTest, TheMotorsPushOnlyWhereThisUnitsFrictionWasMeasured) {
  const core::CoreParams& params = prepared_.header.params;
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(params.friction_mn, (std::array{25, 25, 25}));
  EXPECT_FALSE(params.friction_measured);
  // Too wide an interval.
  Keep("hid:1209:0001:SN7", 0, scene::Measured{40, 7, 40});
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_FALSE(params.friction_measured);
  Keep("hid:1209:0001:SN7", 0, scene::Measured{40, 4, 40});
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(params.friction_mn, (std::array{35, 35, 35}));
  EXPECT_TRUE(params.friction_measured);
  EXPECT_TRUE(
      scene::CheckParams(prepared_.scene, prepared_.exercise, prepared_.profile, params).ok());
}

TEST_F(DeviceDelayTest, AnAttemptThatPushesIsNotResumedOnAUnitWithLessFriction) {
  Keep("hid:1209:0001:SN7", 0, scene::Measured{40, 4, 40});
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  prepared_.core = std::make_unique<core::Core>(prepared_.header.params, prepared_.volume);
  EXPECT_TRUE(UseDelay(Attached(true)).ok());
  Keep("hid:1209:0001:SN7", 0, scene::Measured{60, 4, 40});
  EXPECT_TRUE(UseDelay(Attached(true)).ok()) << "more is safe";
  for (const auto& less :
       {std::optional(scene::Measured{34, 2, 40}), std::optional<scene::Measured>()}) {
    Keep("hid:1209:0001:SN7", 0, less);
    const Status refused = UseDelay(Attached(true));
    EXPECT_EQ(refused.code(), Code::kConflict);
    EXPECT_EQ(refused.field(), "friction_mn");
    EXPECT_NE(refused.message().find("begun on a device with 35 mN"), std::string::npos)
        << refused.message();
  }
}

TEST_F(DeviceDelayTest, ADeviceThatAnswersLaterThanAnAttemptCanBearIsRefusedByName) {
  Keep("hid:1209:0001:SN7", 16);
  EXPECT_TRUE(UseDelay(Attached(true)).ok());
  Keep("hid:1209:0001:SN7", 17);
  const Status refused = UseDelay(Attached(true));
  EXPECT_EQ(refused.field(), "bus_delay_ticks");
  EXPECT_EQ(refused.message().find("arm: 17 ticks of delay"), 0u) << refused.message();
  EXPECT_NE(refused.message().find("connect the device directly"), std::string::npos);
  // Softer than any force that a hand feels, before the core's limit.
  prepared_.profile.damping_mn_s_per_m.value = 100;
  EXPECT_EQ(UseDelay(Attached(true)).field(), "bus_delay_ticks");
}

TEST_F(DeviceDelayTest, AProfileThatSaysItWasMeasuredIsBelieved) {
  prepared_.profile.delay_measured = true;
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 2500);
}

// b = 1 N s/m, 1 kHz: 2000/(d + 1)^2. The profile has a tick of delay behind the answers.
TEST_F(DeviceDelayTest, AnInverse3WhoseAnswersTakeThreeTicksIsComputedWithThem) {
  prepared_.profile = *scene::FindProfile("inverse3");
  lab::EmulatedInverse3 service;
  hid::DeviceChoice choice;
  choice.device = service.choice();
  for (const int delay_us : {0, 3000}) {
    service.Delay(std::chrono::microseconds(delay_us), std::chrono::microseconds(200));
    auto device = sdk::OpenChosenDevice(choice, prepared_.profile, 1e-3);
    ASSERT_TRUE(device.ok()) << device.status().message();
    // On a busy computer the answers come later than the set delay, never sooner.
    const auto measured = AwaitPace(**device).answers;
    ASSERT_TRUE(measured.has_value());
    EXPECT_GT(measured->answers, 0);
    EXPECT_GE(measured->median_us, delay_us);
    EXPECT_GE(measured->p99_us, measured->median_us);
    LogLines log;
    const scene::AnswerTime answers{delay_us + 100, delay_us + 190, kAnswersToKnow};
    ASSERT_TRUE(UseDelayOf(prepared_, **device, {answers, {}}, folder_).ok());
    EXPECT_TRUE(prepared_.delay && prepared_.delay->answers == answers);
    const int ticks = delay_us == 0 ? 2 : 8;  // one, and that of the profile; twice four less one
    EXPECT_EQ(prepared_.delay->ticks, ticks);
    EXPECT_EQ(prepared_.header.params.bus_delay_ticks, static_cast<uint32_t>(ticks));
    EXPECT_EQ(Kc(), 2000 / ((ticks + 1) * (ticks + 1)));
    EXPECT_TRUE(log.Has("99 of 100 answers within")) << log.text();
    EXPECT_TRUE(scene::CheckParams(prepared_.scene, prepared_.exercise, prepared_.profile,
                                   prepared_.header.params)
                    .ok());
    if (delay_us != 0) EXPECT_EQ(prepared_.delay->from, scene::DelayUsed::From::kAnswers);
  }
}

// b = 1.75 N s/m, 1 kHz, a delay of 0 that somebody measured: 3500/(d + 1)^2.
TEST_F(DeviceDelayTest, ADeviceWhosePosesComeSlowlyIsComputedWithThemAndGivesNoEnergy) {
  prepared_.profile.delay_measured = true;
  const auto told = prepared_.header.params;
  const double b = static_cast<double>(prepared_.profile.viscous_mn_s_per_m()) * 1e-3;
  for (const auto& [period_ms, ticks, kc] : {std::tuple{4, 3u, 218}, {2, 1u, 875}}) {
    LogLines log;
    const scene::PosePeriod poses{period_ms * 1000, period_ms * 1000, 200};
    ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), {{}, poses}, folder_).ok());
    EXPECT_EQ(prepared_.delay->from, scene::DelayUsed::From::kPoses);
    EXPECT_EQ(prepared_.header.params.bus_delay_ticks, ticks);
    EXPECT_EQ(Kc(), kc);
    EXPECT_TRUE(log.Has("its poses come more slowly than the ticks (one each " +
                        std::to_string(period_ms) + ".0"))
        << log.text();
    double told_j = 0, used_j = 0;
    for (uint64_t seed = 1; seed <= 200; ++seed) {
      told_j = std::max(told_j, Drawn_j(told, b, period_ms, seed));
      used_j = std::max(used_j, Drawn_j(prepared_.header.params, b, period_ms, seed));
    }
    EXPECT_GT(told_j, 50e-6) << "as the profile says, it pumps";
    EXPECT_LE(used_j, 1e-12);
    RecordProperty("drawn_as_told_uj_at_" + std::to_string(period_ms) + "_ms",
                   std::to_string(told_j * 1e6));
  }
}

TEST_F(DeviceDelayTest, ADeviceAsQuickAsTheLoopHasNothingAdded) {
  prepared_.profile.delay_measured = true;
  for (const int period_us : {1000, 250}) {
    const scene::PosePeriod poses{period_us, period_us, 200};
    ASSERT_TRUE(UseDelayOf(prepared_, Attached(true), {{}, poses}, folder_).ok());
    EXPECT_EQ(prepared_.delay->from, scene::DelayUsed::From::kProfile) << period_us;
    EXPECT_EQ(prepared_.delay->poses, poses);
  }
}

// A busy computer looks late, at half of the poses or more, so only the least is checked. PoseWatchTest checks the exact
// period, on a simulated clock.
TEST_F(DeviceDelayTest, ThePeriodOfADevicesPosesIsMeasured) {
  for (const int period_us : {4000, 1000}) {
    const DevicePace pace = AwaitPace(Paced(std::chrono::microseconds(period_us)));
    ASSERT_TRUE(pace.poses);
    EXPECT_GE(static_cast<double>(pace.poses->median_us), 0.9 * period_us);
  }
}

// Looks each 0.1 ms at a device's count of `poses`, but for the times at which the computer `is_away`.
scene::PosePeriod Watched(const std::function<uint64_t(int64_t us)>& poses,
                          const std::function<bool(int64_t us)>& is_away) {
  PoseWatch watch;
  for (int64_t us = 0; us < 300'000; us += 100) {
    if (!is_away(us)) watch.Look(us * 1000, poses(us));
  }
  return watch.period().value_or(scene::PosePeriod{});
}

TEST(PoseWatchTest, ABusThatBringsFourPosesAtOnceBringsOneIn4ms) {
  const auto found = Watched([](int64_t us) { return static_cast<uint64_t>(us / 4000 * 4); },
                             [](int64_t) { return false; });
  EXPECT_EQ(found.median_us, 4000);
  EXPECT_EQ(found.p99_us, 4000);
}

TEST(PoseWatchTest, LooksThatAComputerMissesAreNoLatePoses) {
  const auto each_ms = [](int64_t us) { return static_cast<uint64_t>(us / 1000); };
  // Away for 12 of each 50 ms.
  auto found = Watched(each_ms, [](int64_t us) { return us % 50'000 > 38'000; });
  EXPECT_EQ(found.median_us, 1000);
  EXPECT_EQ(found.p99_us, 1000);
  // A timer of 4 ms never looks in between: a loop on it does not either.
  found = Watched(each_ms, [](int64_t us) { return us % 4000 != 0; });
  EXPECT_EQ(found.median_us, 4000);
}

TEST(PoseWatchTest, OfNoPosesOrFewNothingIsSaid) {
  PoseWatch watch;
  EXPECT_FALSE(watch.period());
  for (int64_t ms = 0; ms < 19; ++ms) watch.Look(ms * 1'000'000, static_cast<uint64_t>(ms));
  EXPECT_FALSE(watch.period());
}

TEST_F(DeviceDelayTest, ABrokenMeasurementCountsAsNoneAndIsSaid) {
  fs::create_directories(CalibrationsFolder(folder_));
  std::ofstream(CalibrationFile(folder_, "hid:1209:0001:SN7")) << "{\"enamel_calibration\": 1";
  LogLines log;
  ASSERT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 875);
  EXPECT_TRUE(log.Has("counts as not measured")) << log.text();
}

TEST_F(DeviceDelayTest, AResumedAttemptKeepsItsParametersOrIsRefusedWhereTheyAreTooStiff) {
  prepared_.core = std::make_unique<core::Core>(prepared_.header.params, prepared_.volume);
  Status refused = UseDelay(Attached(true));
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("875"), std::string::npos) << refused.message();
  EXPECT_EQ(Kc(), 2500);
  prepared_.header.params.kc_mn_per_mm = 800;
  refused = UseDelay(Attached(true));
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_EQ(refused.field(), "bus_delay_ticks");
  prepared_.header.params.bus_delay_ticks = 1;
  EXPECT_TRUE(UseDelay(Attached(true)).ok());
  EXPECT_EQ(Kc(), 800);
}

}  // namespace
}  // namespace enamel::station
