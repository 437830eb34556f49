#include "station/devices/polled_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "tests/support/await_sample.h"

namespace enamel::station {
namespace {

// A library whose reads return when the test permits.
struct Script {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<PolledBus::Pose> poses;
  size_t read = 0;
  bool gone = false;
  std::vector<dvec3> sent;

  void Let(const dvec3& tip, bool pedal = false) {
    std::lock_guard lock(mutex);
    poses.push_back({tip, {}, pedal});
    changed.notify_all();
  }
  void Unplug() {
    std::lock_guard lock(mutex);
    gone = true;
    changed.notify_all();
  }
  // Among all calls, not only the last: a force that is not renewed ends within milliseconds.
  // Called in Await.
  bool WasSent(const dvec3& force_n) const {
    return std::ranges::find(sent, force_n) != sent.end();
  }
  template <typename What>
  bool Await(What what) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(10), what);
  }
};

class ScriptedBus final : public PolledBus {
 public:
  explicit ScriptedBus(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  std::string Name() const override { return "scripted library"; }
  std::string Driver() const override { return "scripted"; }
  Heard Read(Pose& out) override {
    std::unique_lock lock(script_->mutex);
    // Bounded, like a library's call: it then reads the same pose again.
    script_->changed.wait_for(lock, std::chrono::milliseconds(5), [&] {
      return script_->gone || script_->read < script_->poses.size();
    });
    if (script_->gone) return Heard::kGone;
    if (script_->read < script_->poses.size()) newest_ = script_->poses[script_->read++];
    out = newest_;
    script_->changed.notify_all();
    return Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    std::lock_guard lock(script_->mutex);
    script_->sent.push_back(force_n);
    script_->changed.notify_all();
    return !script_->gone;
  }

 private:
  std::shared_ptr<Script> script_;
  Pose newest_;
};

class PolledDeviceTest : public testing::Test {
 protected:
  PolledDeviceTest() {
    script_->Let({0.1, 0.2, 0.3});
    device_ = std::make_unique<PolledDevice>(std::make_unique<ScriptedBus>(script_), 10e-6);
  }
  template <typename Wanted>
  DeviceSample Until(Wanted wanted) {
    return test::AwaitSample(*device_, wanted);
  }

  std::shared_ptr<Script> script_ = std::make_shared<Script>();
  std::unique_ptr<PolledDevice> device_;
};

// Evenly spread over 10 ms, n answers: half of 1.96 standard errors to each side, sqrt(p (1 - p)/n)/density,
// and the histogram's bucket, 1/32 of the value.
TEST(AnswerTimeTest, ItsIntervalsAreThoseOfQuantiles) {
  for (const int64_t n : {100, 10'000}) {
    DurationHistogram times;
    for (int64_t i = 0; i < n; ++i) times.Add((10'000'000 * i + 5'000'000) / n);
    const scene::AnswerTime found = AnswerTimeOf(times);
    const double root = std::sqrt(static_cast<double>(n));
    const auto near = [](int64_t us, double expected_us, double bucket_us) {
      EXPECT_NEAR(static_cast<double>(us), expected_us, bucket_us);
    };
    near(found.median_us, 5000, 200);
    near(found.p99_us, 9900, 350);
    near(found.median_half_us, 1.96 * 5000 / root + 80, 150);
    // Above the largest there is nothing: only the lower side counts in full for few answers.
    near(found.p99_half_us, 1.96 * 995 / root + 155, n == 100 ? 200 : 150);
    EXPECT_EQ(found.answers, n);
  }
}

TEST_F(PolledDeviceTest, CountsFromTheFirstPoseOn) {
  Until([](const DeviceSample& s) { return s.fresh; });
  script_->Let({0.1001, 0.2, 0.29995}, true);
  DeviceSample s = Until([](const DeviceSample& d) { return d.buttons == kPedal; });
  EXPECT_EQ(s.counts, (std::array<int32_t, 3>{10, 0, -5}));
  EXPECT_EQ(s.bur_speed_krpm, kTurbineSpeed_krpm);
  EXPECT_TRUE(s.attached);
}

TEST_F(PolledDeviceTest, SendsTheNewestForceAndEndsWithZero) {
  device_->SendForce(dvec3(0, 0, 1));
  EXPECT_TRUE(script_->Await([&] { return script_->WasSent({0, 0, 1}); }));
  device_->SendForce(dvec3(0, 0, 2));
  device_.reset();
  EXPECT_EQ(script_->sent.back(), dvec3(0));
}

TEST_F(PolledDeviceTest, ForceTheLoopNoLongerRenewsIsGone) {
  device_->SendForce(dvec3(3, 0, 0));
  ASSERT_TRUE(script_->Await([&] { return script_->WasSent({3, 0, 0}); }));
  EXPECT_TRUE(script_->Await([&] { return script_->sent.back() == dvec3(0); }));
}

TEST_F(PolledDeviceTest, UnpluggedIsSeenAndStays) {
  Until([](const DeviceSample& s) { return s.fresh; });
  script_->Unplug();
  DeviceSample s = Until([](const DeviceSample& d) { return !d.attached; });
  EXPECT_FALSE(s.fresh);
  EXPECT_EQ(s.buttons, 0);
  EXPECT_FALSE(device_->ReadSample().attached);
  EXPECT_EQ(device_->counters().detached, 1u);
}

// Its answers take three ticks, each a cell further along z.
class SlowBus final : public PolledBus {
 public:
  explicit SlowBus(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  std::string Name() const override { return "slow device"; }
  std::string Driver() const override { return "slow"; }
  bool answers() const override { return true; }
  Heard Read(Pose& out) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    out.tip_m = {0, 0, answers_++ * 10e-6};
    return Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    std::lock_guard lock(script_->mutex);
    script_->sent.push_back(force_n);
    return true;
  }

 private:
  std::shared_ptr<Script> script_;
  int answers_ = 0;
};

// Otherwise its delay is two answers: the force sent in one would be from the pose before.
TEST(AnsweringDeviceTest, AForceSentAnswersTheNewestPose) {
  auto script = std::make_shared<Script>();
  scene::AnswerTime took;
  {
    PolledDevice device(std::make_unique<SlowBus>(script), 10e-6);
    auto due = std::chrono::steady_clock::now();
    for (int i = 0; i < 400; ++i) {
      std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
      device.SendForce(dvec3(0, 0, 1.0 * device.ReadSample().counts[2]));
    }
    took = device.answer_time().value();
  }
  EXPECT_GE(took.median_us, 3000);
  EXPECT_GE(took.p99_us, took.median_us);
  EXPECT_GE(took.answers, 20);
  // A test that is not woken in time answers late: most, not all.
  size_t newest = 0;
  for (size_t i = 1; i < script->sent.size(); ++i) {
    newest += script->sent[i].z == static_cast<double>(i - 1);
  }
  EXPECT_GT(newest, script->sent.size() / 2);
}

// Says where it is only in answer to a force, unless it is mute.
class AnsweringBus final : public PolledBus {
 public:
  explicit AnsweringBus(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  std::string Name() const override { return "answering device"; }
  std::string Driver() const override { return "answering"; }
  std::string Unit() const override { return "usb:1-2"; }
  bool answers() const override { return true; }
  Heard Read(Pose& out) override {
    std::lock_guard lock(script_->mutex);
    if (script_->gone) return Heard::kGone;
    if (!asked_ || script_->poses.empty()) return Heard::kNothing;
    asked_ = false;
    out = script_->poses.back();
    return std::isfinite(out.tip_m.x) ? Heard::kPose : Heard::kRefused;
  }
  bool Send(const dvec3& force_n) override {
    std::lock_guard lock(script_->mutex);
    asked_ = true;
    script_->sent.push_back(force_n);
    script_->changed.notify_all();
    return !script_->gone;
  }

 private:
  std::shared_ptr<Script> script_;
  bool asked_ = false;
};

TEST(AnsweringDeviceTest, ItIsAskedWithoutAForceAndEachAnswerIsNewsOnce) {
  auto script = std::make_shared<Script>();
  PolledDevice device(std::make_unique<AnsweringBus>(script), 10e-6);
  EXPECT_EQ(device.Unit(), "usb:1-2");
  // Mute: asked again and again, with nothing to report.
  ASSERT_TRUE(script->Await([&] { return script->sent.size() >= 10; }));
  EXPECT_FALSE(device.ReadSample().fresh);
  EXPECT_TRUE(device.ReadSample().attached);
  EXPECT_EQ(device.counters().samples, 0u);
  EXPECT_EQ(script->sent.front(), dvec3(0));
  script->Let({0, 0, 0});
  test::AwaitSample(device, [](const DeviceSample& s) { return s.fresh; });
  device.SendForce(dvec3(0, 0, 1));
  EXPECT_TRUE(script->Await([&] { return script->WasSent({0, 0, 1}); }));
  script->Let(dvec3(NAN));
  for (int i = 0; i < 10'000 && device.counters().refused == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(device.counters().refused, 1u);
  script->Unplug();
  test::AwaitSample(device, [](const DeviceSample& s) { return !s.attached; });
}

}  // namespace
}  // namespace enamel::station
