#include "station/devices/polled_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "station/devices/force_keeper.h"

namespace enamel::station {
namespace {

// Interval of the keeper's repeats; a maker's library has no watchdog to feed, but its motors hold
// the last force.
constexpr int kRepeat_ms = 4;
constexpr double kMostCounts = 2147483647.0;

int64_t Now_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

}  // namespace

PolledDevice::PolledDevice(std::unique_ptr<PolledBus> bus, double resolution_m,
                           std::function<void()> thread_setup)
    : bus_(std::move(bus)),
      name_(bus_->Name()),
      driver_(bus_->Driver()),
      unit_(bus_->Unit()),
      answers_(bus_->answers()),
      resolution_m_(resolution_m),
      thread_setup_(std::move(thread_setup)),
      thread_([this] { Run(); }) {
  ENAMEL_CHECK(resolution_m > 0);
}

PolledDevice::~PolledDevice() {
  stop_ = true;
  force_signal_.Post();
  thread_.join();
}

DeviceSample PolledDevice::ReadSample() noexcept {
  const Message& newest = poses_.Read();
  DeviceSample sample = newest.sample;
  sample.fresh = newest.number != seen_ && newest.sample.attached;
  sample.attached = newest.number == 0 || newest.sample.attached;
  seen_ = newest.number;
  return sample;
}

void PolledDevice::SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept {
  forces_.Write({force_n, torque_n_m, ++sent_});
  if (answers_) force_signal_.Post();
}

DeviceCounters PolledDevice::counters() const noexcept {
  DeviceCounters out;
  out.samples = samples_;
  out.refused = refused_;
  out.writes = writes_;
  out.detached = detached_;
  return out;
}

void PolledDevice::Publish(const PolledBus::Pose& pose, bool attached) {
  if (published_ == 0) centre_m_ = pose.tip_m;
  Message m;
  for (int i = 0; i < 3; ++i) {
    double counts = (pose.tip_m[i] - centre_m_[i]) / resolution_m_;
    m.sample.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(std::clamp(counts, -kMostCounts, kMostCounts)));
  }
  m.sample.orientation = ToQuantised(pose.orientation);
  m.sample.attached = attached;
  if (attached && pose.pedal) {
    m.sample.buttons = kPedal;
    m.sample.bur_speed_krpm = kTurbineSpeed_krpm;
  }
  m.number = ++published_;
  m.sample.sequence = static_cast<uint32_t>(m.number);
  poses_.Write(m);
}

// False: the device is gone.
bool PolledDevice::Hear(PolledBus::Pose& pose) {
  PolledBus::Pose read;
  const PolledBus::Heard heard = bus_->Read(read);
  if (heard == PolledBus::Heard::kPose && std::isfinite(Dot(read.tip_m, read.tip_m))) {
    pose = read;
    Publish(pose, true);
    ++samples_;
  } else if (heard == PolledBus::Heard::kPose || heard == PolledBus::Heard::kRefused) {
    ++refused_;
  }
  return heard != PolledBus::Heard::kGone;
}

void PolledDevice::Run() {
  if (thread_setup_) thread_setup_();
  ForceKeeper keeper(kRepeat_ms);
  PolledBus::Pose pose;
  bool here = true;
  while (!stop_ && here) {
    if (answers_) force_signal_.Wait(keeper.WaitFor_us(Now_us()));
    const Force newest = forces_.Read();
    const int64_t now = Now_us();
    keeper.Take(newest.newtons, newest.number, now, newest.newton_metres);
    const auto command = keeper.Next(now);
    if (command) {
      here = bus_->SendWithTorque(command->force_n, command->torque_n_m);
      writes_ += here;
    }
    // Unasked, a device that only answers would be waited for in vain.
    if (here && (command || !answers_)) here = Hear(pose);
  }
  if (!here) {
    Publish(pose, false);
    ++detached_;
  }
  (void)bus_->SendWithTorque(dvec3(0), dvec3(0));
}

}  // namespace enamel::station
