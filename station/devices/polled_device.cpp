#include "station/devices/polled_device.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "station/devices/trouble.h"

namespace enamel::station {
namespace {

// Interval of the keeper's repeats; a maker's library has no watchdog to feed, but its motors hold
// the last force.
constexpr int kRepeat_ms = 4;
// Time for the loop to answer a pose, before a force that does not is sent again.
constexpr int64_t kSilence_us = 1'000;
constexpr double kMaxCounts = 2147483647.0;
constexpr double kFarthest_m = 10;  // no arm reaches

int64_t Now_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

int64_t Now_us() { return Now_ns() / 1000; }

bool AreNear(const dvec3& a_m, const dvec3& b_m) {
  const dvec3 d = a_m - b_m;
  return Dot(d, d) < PolledDevice::kFar_m * PolledDevice::kFar_m;
}

// Looking for a device takes the processor for milliseconds, which the tick's priority must not give it.
void TakeOrdinaryPriority() {
  const sched_param ordinary{};
  (void)::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &ordinary);
}

}  // namespace

// Comparisons with what is not a number fail.
bool CanBe(const PolledBus::Pose& pose) noexcept {
  const Quat& q = pose.orientation;
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return Dot(pose.tip_m, pose.tip_m) < kFarthest_m * kFarthest_m && square > 0.81 && square < 1.21;
}

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
                           std::function<void()> thread_setup, ReopenBus reopen)
    : bus_(std::move(bus)),
      name_(bus_->Name()),
      driver_(bus_->Driver()),
      unit_(bus_->Unit()),
      answers_(bus_->answers()),
      counts_from_power_up_(bus_->counts_from_power_up()),
      resolution_m_(resolution_m),
      thread_setup_(std::move(thread_setup)),
      reopen_(std::move(reopen)),
      keeper_(kRepeat_ms),
      thread_([this] { Run(); }) {
  ENAMEL_CHECK(resolution_m > 0);
}

PolledDevice::~PolledDevice() {
  {
    MutexLock lock(mutex_);
    stop_ = true;
    stopping_.notify_all();
  }
  force_signal_.Post();
  thread_.join();
}

DeviceSample PolledDevice::ReadSample() noexcept {
  const Message& newest = poses_.Read();
  DeviceSample sample = newest.sample;
  sample.fresh = newest.number != seen_ && newest.sample.attached;
  sample.attached = newest.number == 0 || newest.sample.attached;
  // Also one that was back before this tick.
  if (newest.absences != seen_absences_) sample.attached = sample.fresh = false;
  seen_absences_ = newest.absences;
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

Status PolledDevice::problem() const {
  MutexLock lock(mutex_);
  return problem_;
}

void PolledDevice::Note(const Status& problem) {
  MutexLock lock(mutex_);
  problem_ = problem;
}

void PolledDevice::Publish(bool attached) {
  if (attached && !std::exchange(centred_, true)) centre_m_ = pose_.tip_m;
  absences_ += !attached;
  Message m;
  m.absences = absences_;
  for (int i = 0; i < 3; ++i) {
    double counts = (pose_.tip_m[i] - centre_m_[i]) / resolution_m_;
    m.sample.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(std::clamp(counts, -kMaxCounts, kMaxCounts)));
  }
  m.sample.orientation = ToQuantised(pose_.orientation);
  m.sample.attached = attached;
  m.sample.driven = pose_.driven;
  if (attached && pose_.pedal) {
    m.sample.buttons = kPedal;
    m.sample.bur_speed_krpm = kTurbineSpeed_krpm;
  }
  if (attached && pose_.second) m.sample.buttons |= kSecond;
  m.number = ++published_;
  m.sample.sequence = static_cast<uint32_t>(m.number);
  poses_.Write(m);
}

// Whether a hand can be there.
bool PolledDevice::IsReached(const dvec3& tip_m) {
  agreeing_ = AreNear(tip_m, read_m_) ? agreeing_ + 1 : 0;
  read_m_ = tip_m;
  const bool is_unforced = Now_us() - posed_us_ > std::chrono::microseconds(kUnforced).count();
  return !posed_ || AreNear(tip_m, pose_.tip_m) || (agreeing_ >= kAgreeing && is_unforced);
}

// False: the device no longer answers. Makes `asked_ns` earlier if the answer is to an earlier question.
bool PolledDevice::Hear(int64_t& asked_ns) {
  PolledBus::Pose read;
  const PolledBus::Heard heard = bus_->Read(read);
  if (heard == PolledBus::Heard::kPose && CanBe(read) && IsReached(read.tip_m)) {
    pose_ = read;
    posed_ = true;
    posed_us_ = Now_us();
    Publish(true);
    ++samples_;
    if (read.asked_ns > 0) asked_ns = std::min(asked_ns, read.asked_ns);
  } else if (heard == PolledBus::Heard::kPose || heard == PolledBus::Heard::kRefused) {
    ++refused_;
  }
  return heard != PolledBus::Heard::kGone;
}

// The newest force, once it is one that the loop computed from the newest pose. A force from the pose before
// that, sent at once after an answer of several ticks, would make the delay two such answers.
PolledDevice::Force PolledDevice::AwaitForce() {
  const int64_t begin_us = Now_us();
  const int64_t until_us =
      std::max(begin_us + keeper_.WaitFor_us(begin_us), heard_us_ + kSilence_us);
  while (true) {
    const Force newest = forces_.Read();
    const int64_t left_us = until_us - Now_us();
    const bool is_due = newest.number > taken_ && newest.seen == published_;
    if (is_due || left_us <= 0 || stop_) return newest;
    force_signal_.Wait(left_us);
  }
}

// Until the device is away, or this ends.
void PolledDevice::Serve() {
  constexpr int64_t kSilentFor_us = std::chrono::microseconds(kSilentFor).count();
  bool here = true;
  posed_ = false;
  posed_us_ = Now_us();
  while (!stop_ && here) {
    const Force newest = answers_ ? AwaitForce() : forces_.Read();
    taken_ = newest.number;
    int64_t asked_ns = Now_ns();
    const int64_t now_us = asked_ns / 1000;
    if (reopen_ && now_us - posed_us_ > kSilentFor_us) {
      return Note(Status(Code::kUnavailable, name_ + " does not answer", trouble::kSilent));
    }
    keeper_.Take(newest.newtons, newest.number, now_us, newest.newton_metres);
    const auto command = keeper_.Next(now_us);
    if (command) {
      here = bus_->SendWithTorque(command->force_n, command->torque_n_m);
      writes_ += here;
    }
    // Nothing was sent, so nothing will answer.
    if (!here || (answers_ && !command)) continue;
    here = Hear(asked_ns);
    if (!answers_) continue;
    const int64_t heard_ns = Now_ns();
    answers_ns_.Add(heard_ns - asked_ns);
    heard_us_ = heard_ns / 1000;
  }
  if (!here) Note(Status(Code::kUnavailable, name_ + " is detached", trouble::kNotAttached));
}

void PolledDevice::Wait(std::chrono::milliseconds duration) {
  MutexLock lock(mutex_);
  stopping_.wait_for(mutex_, duration, [this] { return stop_.load(); });
}

Status PolledDevice::CheckUnit(const PolledBus& bus) const {
  const std::string found = bus.Unit();
  if (found == unit_ && bus.Name() == name_) return Status::Ok();
  return Status(Code::kConflict,
                "expected " + name_ + " (" + unit_ + "), with which this began, found " +
                    bus.Name() + " (" + found + "): connect that one, to the socket where it was",
                trouble::kOtherUnit);
}

// Asks a device that counts_from_power_up whether it is still where it was. Once only: a hand would lead a
// lost arm past that place.
Status PolledDevice::CheckPlace(PolledBus& bus) {
  PolledBus::Pose pose;
  bool heard = false;
  const int64_t until_us = Now_us() + std::chrono::microseconds(kLongestWait).count();
  while (!heard && Now_us() < until_us && bus.Send(dvec3(0))) {
    heard = bus.Read(pose) == PolledBus::Heard::kPose && CanBe(pose);
  }
  if (!heard) return Status(Code::kUnavailable, name_ + " does not answer", trouble::kSilent);
  if (bus.is_calibrated_anew())
    is_lost_ = false;
  else
    is_lost_ = is_lost_ || !AreNear(pose.tip_m, pose_.tip_m);
  if (!is_lost_) return Status::Ok();
  return Status(Code::kUnavailable,
                name_ +
                    " may have lost its place with its power: calibrate it, and begin again or "
                    "continue after a new sign-in",
                trouble::kLost);
}

Status PolledDevice::CheckReopened(const Result<std::unique_ptr<PolledBus>>& opened) {
  // An arm that is not near its middle may be lost, and may pass there later.
  if (counts_from_power_up_ && opened.status().field() == trouble::kMiddle) is_lost_ = true;
  ENAMEL_RETURN_IF_ERROR(opened.status());
  ENAMEL_RETURN_IF_ERROR(CheckUnit(**opened));
  return counts_from_power_up_ ? CheckPlace(**opened) : Status::Ok();
}

// The bus of the same unit, once it is back; null: this ends.
std::unique_ptr<PolledBus> PolledDevice::Reopened() {
  TakeOrdinaryPriority();
  for (auto wait = kFirstWait; !stop_; wait = std::min(2 * wait, kLongestWait)) {
    Wait(wait);
    if (stop_) break;
    auto opened = reopen_();
    const Status found = CheckReopened(opened);
    Note(found);
    if (!found.ok()) continue;
    if (thread_setup_) thread_setup_();
    return std::move(*opened);
  }
  return nullptr;
}

void PolledDevice::Run() {
  if (thread_setup_) thread_setup_();
  while (bus_ != nullptr) {
    Serve();
    (void)bus_->SendWithTorque(dvec3(0), dvec3(0));
    if (stop_) return;
    Publish(false);
    ++detached_;
    // Closed first: many devices can be opened once only.
    bus_.reset();
    if (reopen_) bus_ = Reopened();
  }
}

}  // namespace enamel::station
