#include "station/devices/polled_device.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  bool Read(Pose& out) override {
    std::unique_lock lock(script_->mutex);
    // Bounded, like a library's call: it then reads the same pose again.
    script_->changed.wait_for(lock, std::chrono::milliseconds(5), [&] {
      return script_->gone || script_->read < script_->poses.size();
    });
    if (script_->gone) return false;
    if (script_->read < script_->poses.size()) newest_ = script_->poses[script_->read++];
    out = newest_;
    script_->changed.notify_all();
    return true;
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

}  // namespace
}  // namespace enamel::station
