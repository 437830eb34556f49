#include "station/devices/polled_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace enamel::station {
namespace {

// Interval of the keeper's repeats; a maker's library has no watchdog to feed, but its motors hold
// the last force.
constexpr int kRepeat_ms = 4;
// Time for the loop to answer a pose, before a force that does not is sent again.
constexpr int64_t kSilence_us = 1'000;
constexpr double kMostCounts = 2147483647.0;

int64_t Now_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

int64_t Now_us() { return Now_ns() / 1000; }

}  // namespace

scene::AnswerTime AnswerTimeOf(const DurationHistogram& answers_ns) noexcept {
  const auto us = [&](double share) {
    return std::lround(std::ceil(answers_ns.Quantile_ns(share) * 1e-3));
  };
  const auto count = static_cast<int64_t>(answers_ns.count());
  // How many of n answers are within a quantile is binomial: its 95 % interval is between the quantiles of
  // p -+ 1.96 sqrt(p (1 - p)/n). Each of those is known to half a bucket.
  const auto half_us = [&](double p) {
    const double n = static_cast<double>(std::max<int64_t>(count, 1));
    const double off = 1.96 * std::sqrt(p * (1 - p) / n);
    const int64_t width = us(std::min(p + off, 1.0)) - us(std::max(p - off, 0.0));
    return (width + us(p) / DurationHistogram::kSplit + 1) / 2;
  };
  return {us(0.5), us(0.99), count, half_us(0.5), half_us(0.99)};
}

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
  forces_.Write({force_n, torque_n_m, ++sent_, seen_});
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

std::optional<scene::AnswerTime> PolledDevice::answer_time() const noexcept {
  if (!answers_) return std::nullopt;
  return AnswerTimeOf(answers_ns_);
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
  m.sample.driven = pose.driven;
  if (attached && pose.pedal) {
    m.sample.buttons = kPedal;
    m.sample.bur_speed_krpm = kTurbineSpeed_krpm;
  }
  if (attached && pose.second) m.sample.buttons |= kSecond;
  m.number = ++published_;
  m.sample.sequence = static_cast<uint32_t>(m.number);
  poses_.Write(m);
}

// False: the device no longer answers. Makes `asked_ns` earlier if the answer is to an earlier question.
bool PolledDevice::Hear(PolledBus::Pose& pose, int64_t& asked_ns) {
  PolledBus::Pose read;
  const PolledBus::Heard heard = bus_->Read(read);
  if (heard == PolledBus::Heard::kPose && std::isfinite(Dot(read.tip_m, read.tip_m))) {
    pose = read;
    Publish(pose, true);
    ++samples_;
    if (pose.asked_ns > 0) asked_ns = std::min(asked_ns, pose.asked_ns);
  } else if (heard == PolledBus::Heard::kPose || heard == PolledBus::Heard::kRefused) {
    ++refused_;
  }
  return heard != PolledBus::Heard::kGone;
}

// The newest force, once it is one that the loop computed from the newest pose. A force from the pose before
// that, sent at once after an answer of several ticks, would make the delay two such answers.
PolledDevice::Force PolledDevice::AwaitForce(const ForceKeeper& keeper) {
  const int64_t begin_us = Now_us();
  const int64_t until_us =
      std::max(begin_us + keeper.WaitFor_us(begin_us), heard_us_ + kSilence_us);
  while (true) {
    const Force newest = forces_.Read();
    const int64_t left_us = until_us - Now_us();
    const bool is_due = newest.number > taken_ && newest.seen == published_;
    if (is_due || left_us <= 0 || stop_) return newest;
    force_signal_.Wait(left_us);
  }
}

void PolledDevice::Run() {
  if (thread_setup_) thread_setup_();
  ForceKeeper keeper(kRepeat_ms);
  PolledBus::Pose pose;
  bool here = true;
  while (!stop_ && here) {
    const Force newest = answers_ ? AwaitForce(keeper) : forces_.Read();
    taken_ = newest.number;
    int64_t asked_ns = Now_ns();
    const int64_t now = asked_ns / 1000;
    keeper.Take(newest.newtons, newest.number, now, newest.newton_metres);
    const auto command = keeper.Next(now);
    if (command) {
      here = bus_->SendWithTorque(command->force_n, command->torque_n_m);
      writes_ += here;
    }
    // Unasked, a device that only answers would be waited for in vain.
    if (!here || (answers_ && !command)) continue;
    here = Hear(pose, asked_ns);
    if (!answers_) continue;
    const int64_t heard_ns = Now_ns();
    answers_ns_.Add(heard_ns - asked_ns);
    heard_us_ = heard_ns / 1000;
  }
  if (!here) {
    Publish(pose, false);
    ++detached_;
  }
  (void)bus_->SendWithTorque(dvec3(0), dvec3(0));
}

}  // namespace enamel::station
