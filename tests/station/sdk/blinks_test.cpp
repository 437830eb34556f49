#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>
#include <tuple>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/plan.h"
#include "station/devices/trouble.h"
#include "station/loop/tick_loop.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/every_arm.h"

// A device that goes away in the middle of a cut and comes back: whatever the driver, however it went, the
// attempt is whole and the force is back, in free air.
namespace enamel::station::sdk {
namespace {

using testing_support::AwaitThat;
using testing_support::EmulatedArm;
using testing_support::MakeArm;

enum class Blink { kClosed, kUnpowered, kSilent, kGarbled, kOther };

// The loop with a device of this driver above the block, ticked by the test; the pedal is down all the time.
class Cut {
 public:
  explicit Cut(EmulatedArm& arm) : arm_(arm) {
    hid::DeviceChoice choice;
    choice.device = arm.choice();
    const auto profile = scene::FindProfile(arm.profile());
    auto opened = OpenChosenDevice(choice, *profile, 1e-3);
    ENAMEL_CHECK(opened.ok());
    device_ = std::move(*opened);
    AwaitThat([&] { return device_->counters().samples > 0; });
    auto built = scene::BuildBuiltinScene("block", 200'000);
    ENAMEL_CHECK(built.ok());
    auto params =
        scene::CompilePlan(built->scene, scene::ClassOneExercise(built->scene, {}), *profile);
    ENAMEL_CHECK(params.ok());
    params->device_origin_nm[2] =
        int64_t{built->scene.landmarks.at("occlusal_centre")[2]} * 1000 + 500'000;
    params_ = *params;
    volume_ = built->volume;
    core_.emplace(params_, volume_);
    loop_.emplace(held_, *core_, ring_, TickLoopOptions{1000, false, true});
  }

  // With the device's next answer, if one comes within this time: a tick's, or kAnswered where the device is
  // known to answer, and only a busy computer delays it.
  static constexpr std::chrono::milliseconds kAnswered{1000};
  void Tick(std::chrono::milliseconds patience = std::chrono::milliseconds(1)) {
    const uint64_t before = device_->counters().samples;
    const auto until = std::chrono::steady_clock::now() + patience;
    while (device_->counters().samples == before && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    loop_->Tick();
    for (Sample s; ring_.Pop(s);) recorded_.push_back(s);
  }
  // Down until the tooth pushes back; up again. Ticks that it took.
  int Touch() {
    int ticks = 0;
    while (force() == dvec3(0) && ticks < 3000) {
      // Force comes on in free air only, after rest.
      if (!suspended()) arm_.Lower(step_ = std::min(step_ + 1, 100));
      Tick(kAnswered);
      ++ticks;
    }
    return ticks;
  }
  void LiftOut() { arm_.Lower(step_ = 0); }
  bool suspended() { return (loop_->snapshot().output_flags & core::kSuspended) != 0; }
  Fault fault() const { return loop_->fault(); }
  const dvec3& force() const { return held_.force; }
  Status problem() const { return device_->problem(); }

  void ExpectWhole() {
    core::Core again(params_, volume_);
    uint64_t passed = 0;
    for (const Sample& s : recorded_) {
      ASSERT_EQ(again.Step(s.tick.input).witness, s.tick.witness);
      ASSERT_EQ(again.state_hash(), s.state_hash);
      passed += 1 + s.tick.input.gap_ticks;
    }
    EXPECT_EQ(passed, loop_->snapshot().counters.passed_ticks());
  }

 private:
  // Passes a driver's calls on, the pedal down.
  class Held final : public Device {
   public:
    explicit Held(Cut& cut) : cut_(cut) {}
    std::string Name() const override { return cut_.device_->Name(); }
    Hand hand() const override { return cut_.device_->hand(); }
    DeviceSample ReadSample() noexcept override {
      DeviceSample s = cut_.device_->ReadSample();
      s.buttons = kPedal;
      s.bur_speed_krpm = kTurbineSpeed_krpm;
      return s;
    }
    void SendForce(const dvec3& force_n) noexcept override {
      force = force_n;
      cut_.device_->SendForce(force_n);
    }
    double still_before_force_s() const noexcept override {
      return cut_.device_->still_before_force_s();
    }
    dvec3 force{0};

   private:
    Cut& cut_;
  };

  EmulatedArm& arm_;
  std::unique_ptr<Device> device_;
  Held held_{*this};
  core::CoreParams params_;
  cutting::Volume volume_;
  std::optional<core::Core> core_;
  SampleRing ring_{64};
  std::optional<TickLoop> loop_;
  std::vector<Sample> recorded_;
  int step_ = 0;
};

class BlinksTest : public testing::TestWithParam<std::tuple<const char*, Blink>> {
 protected:
  BlinksTest() { testing_support::HidBus::Get().Reset(); }

  void Go(EmulatedArm& arm) const {
    switch (blink()) {
      case Blink::kClosed:
      case Blink::kOther:
        return arm.Unplug();
      case Blink::kUnpowered:
        return arm.SwitchOff();
      case Blink::kSilent:
        return arm.Mute(true);
      case Blink::kGarbled:
        return arm.Garble(true);
    }
  }
  void ComeBack(EmulatedArm& arm) const {
    switch (blink()) {
      case Blink::kClosed:
      case Blink::kOther:
        return arm.Plug();
      case Blink::kUnpowered:
        return arm.SwitchOn();
      case Blink::kSilent:
        return arm.Mute(false);
      case Blink::kGarbled:
        return arm.Garble(false);
    }
  }
  const char* driver() const { return std::get<0>(GetParam()); }
  Blink blink() const { return std::get<1>(GetParam()); }
};

TEST_P(BlinksTest, CostNothingButForceAndTime) {
  const int rounds = std::getenv("ENAMEL_FULL") != nullptr ? 20 : 1;
  auto arm = MakeArm(driver());
  Cut cut(*arm);
  ASSERT_LT(cut.Touch(), 3000);
  int most_off = 0, most_back = 0;
  for (int round = 0; round < rounds; ++round) {
    Go(*arm);
    // Noise may be a pose, now and then: of a device whose reports carry no check.
    int off = 0;
    for (; cut.force() != dvec3(0) && off < 100; ++off) cut.Tick();
    most_off = std::max(most_off, off);
    if (blink() != Blink::kGarbled) ASSERT_LE(off, 7) << "ticks with force";
    // Shorter and longer than the driver waits before it opens the device again.
    const int away = round % 2 == 0 ? 150 : 1500;
    for (int i = 0; i < away || (cut.fault() == Fault::kNone && i < 2000); ++i) cut.Tick();
    ASSERT_NE(cut.fault(), Fault::kNone);
    ASSERT_EQ(cut.force(), dvec3(0));
    if (blink() == Blink::kOther && arm->PlugOther()) {
      AwaitThat([&] { return cut.problem().field() == trouble::kOtherUnit; });
      for (int i = 0; i < 100; ++i) cut.Tick();
      ASSERT_EQ(cut.fault(), Fault::kUnplugged) << "with another unit";
      arm->Unplug();
    }
    ComeBack(*arm);
    cut.LiftOut();
    int back = 0;
    while ((cut.fault() != Fault::kNone || cut.suspended()) && back < 5000) {
      cut.Tick(cut.problem().ok() ? Cut::kAnswered : std::chrono::milliseconds(1));
      ++back;
    }
    most_back = std::max(most_back, back);
    ASSERT_LE(back, 3000) << cut.problem().message();
    ASSERT_LT(cut.Touch(), 3000);
    ASSERT_TRUE(cut.problem().ok()) << cut.problem().message();
  }
  cut.ExpectWhole();
  std::printf("%s: at most %d ticks with force, back after %d ticks\n", driver(), most_off,
              most_back);
}

class LostPlaceTest : public testing::TestWithParam<const char*> {
 protected:
  LostPlaceTest() { testing_support::HidBus::Get().Reset(); }
};

// Its encoders count from where it was switched on again: elsewhere. A hand then leads it past the place
// where it says it was.
TEST_P(LostPlaceTest, AnArmThatWasSwitchedOnElsewhereHasNoForceUntilItIsCalibrated) {
  const std::string driver = GetParam();
  auto arm = MakeArm(driver);
  Cut cut(*arm);
  ASSERT_LT(cut.Touch(), 3000);
  arm->SwitchOff();
  for (int i = 0; i < 200; ++i) cut.Tick();
  ASSERT_EQ(cut.fault(), Fault::kUnplugged);
  arm->Lower(700);  // 28 mm
  arm->SwitchOn();
  const auto is_refused = [&] {
    const std::string why = cut.problem().field();
    return why == trouble::kLost || why == trouble::kMiddle;
  };
  AwaitThat(is_refused);
  for (int i = 0; i < 2000; ++i) {
    if (i == 300) cut.LiftOut();
    cut.Tick();
    ASSERT_EQ(cut.fault(), Fault::kUnplugged);
    ASSERT_EQ(cut.force(), dvec3(0));
  }
  EXPECT_EQ(cut.problem().field(), trouble::kLost) << cut.problem().message();
  if (auto* serial = dynamic_cast<testing_support::EmulatedSerialArm*>(arm.get())) {
    serial->PressCalibration();
  } else if (driver == "polhem") {
    dynamic_cast<testing_support::EmulatedHidArm&>(*arm).PressCalibration();
  } else {
    return;  // it has no button
  }
  int back = 0;
  while ((cut.fault() != Fault::kNone || cut.suspended()) && ++back < 5000) {
    cut.Tick(cut.problem().ok() ? Cut::kAnswered : std::chrono::milliseconds(1));
  }
  EXPECT_LT(back, 5000) << cut.problem().message();
  ASSERT_LT(cut.Touch(), 3000);
  cut.ExpectWhole();
}

INSTANTIATE_TEST_SUITE_P(Drivers, LostPlaceTest,
                         testing::Values("woodenhaptics", "polhem", "polhem_serial"));

std::string NameOf(const testing::TestParamInfo<std::tuple<const char*, Blink>>& param) {
  constexpr const char* kNames[] = {"closed", "unpowered", "silent", "garbled", "other"};
  return std::string(std::get<0>(param.param)) + "_" +
         kNames[static_cast<size_t>(std::get<1>(param.param))];
}

INSTANTIATE_TEST_SUITE_P(
    Drivers, BlinksTest,
    testing::Combine(testing::Values("dhd", "openhaptics", "woodenhaptics", "polhem",
                                     "polhem_serial", "inverse3", "falcon"),
                     testing::Values(Blink::kClosed, Blink::kUnpowered, Blink::kSilent,
                                     Blink::kGarbled, Blink::kOther)),
    NameOf);

}  // namespace
}  // namespace enamel::station::sdk
