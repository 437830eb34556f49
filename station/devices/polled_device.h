#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <thread>

#include "common/base/mutex.h"
#include "common/base/triple_buffer.h"
#include "station/devices/device.h"
#include "station/devices/duration_histogram.h"
#include "station/devices/force_keeper.h"
#include "station/devices/force_signal.h"

namespace enamel::station {

// A device behind a maker's library or a protocol whose calls may wait for a bus. All calls are on the
// adapter's thread.
class PolledBus {
 public:
  enum class Heard : uint8_t {
    kPose,
    kNothing,  // in time: the device may still be there
    kRefused,  // something that is no pose of this device
    kGone,     // detached, or restarted: its poses mean nothing from now on
  };
  struct Pose {
    dvec3 tip_m{0};                      // scene axes
    Quat orientation;                    // scene from tool
    bool pedal = false, second = false;  // buttons
    bool driven = true;                  // as DeviceSample::driven
    // Of a device that answers, on the steady clock: when this was asked for, if that may have been in an
    // earlier exchange; else 0.
    int64_t asked_ns = 0;
  };

  virtual ~PolledBus() = default;
  virtual std::string Name() const = 0;
  virtual std::string Driver() const = 0;          // as a command line names it: "dhd"
  virtual std::string Unit() const { return {}; }  // as Device::Unit
  // True: its encoders count from where they were when it was switched on. After a loss of power it is
  // elsewhere than it says, until somebody has calibrated it.
  virtual bool counts_from_power_up() const { return false; }
  // Somebody calibrated it since it was opened, by its own button.
  virtual bool is_calibrated_anew() const { return false; }
  // True: the device says where it is only in answer to a force, one answer each.
  virtual bool answers() const { return false; }
  // Both may wait, for a few milliseconds at most.
  virtual Heard Read(Pose& out) = 0;
  // Scene axes; without torque. False: the device is detached.
  virtual bool Send(const dvec3& force_n) = 0;
  virtual bool SendWithTorque(const dvec3& force_n, const dvec3& torque_n_m) {
    (void)torque_n_m;
    return Send(force_n);
  }
};

// True if a device can mean it: a tip within 10 m, and a quaternion within a tenth of unit length, as a
// board's (haptic_board.cpp). False for what is not a number.
bool CanBe(const PolledBus::Pose& pose) noexcept;

// Of the times between questions and whole answers.
scene::AnswerTime AnswerTimeOf(const DurationHistogram& answers_ns) noexcept;

// Opens the bus again after the device went away. Errors: the driver's, with what to do.
using ReopenBus = std::function<Result<std::unique_ptr<PolledBus>>()>;

// Runs a polled device on its own thread, as fast as its bus allows, and exchanges the newest
// values with the tick. A device that only answers has one exchange for each tick in which the loop has
// seen its last answer, and one each millisecond while the loop is silent. A force that the loop has not
// renewed falls to 0 (ForceKeeper). What no device can mean (CanBe) is left out and counted as refused. So
// is a jump of more than kFar, until kAgreeing poses in a row agree on it, kUnforced after the last pose:
// noise seldom does, and the loop has no force by then.
//
// A device that is detached, or gives no pose for kSilentFor, is away: `attached` is false and its bus is
// closed with force 0. With `reopen` the bus is then opened again, after kFirstWait and each time twice as
// long, up to kLongestWait, until the same unit is back. Its middle stays, so the scene does not move.
// Until then problem() says why not, "other_unit" included. A device whose encoders count from power-up may
// have lost its place meanwhile: one that first says it is elsewhere by more than kFar stays away until
// somebody calibrates it by its button, else for good.
//
// Real-time: ReadSample and the Sends are safe. The destructor sends 0. It waits for an exchange, or for a
// bus that is being opened.
class PolledDevice final : public MotorDevice {
 public:
  static constexpr std::chrono::milliseconds kSilentFor{1000};
  static constexpr std::chrono::milliseconds kFirstWait{50}, kLongestWait{200};
  // 4 m/s from one pose to another 5 ms later, faster than a hand at a tooth.
  static constexpr double kFar_m = 0.02;
  static constexpr int kAgreeing = 8;
  static constexpr std::chrono::milliseconds kUnforced{6};  // a tick more than the loop's 5 ms

  // `resolution_m`: edge of a count, from the device profile. The first pose read is the centre.
  // `thread_setup` is called when the thread begins, and again with each bus; it may be empty, as may
  // `reopen`: then a device that went away stays away.
  PolledDevice(std::unique_ptr<PolledBus> bus, double resolution_m,
               std::function<void()> thread_setup = {}, ReopenBus reopen = {});
  ~PolledDevice() override;

  std::string Name() const override { return name_; }
  std::string Unit() const override { return unit_; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, name_, driver_, unit_); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override;
  DeviceCounters counters() const noexcept override;
  std::optional<scene::AnswerTime> answer_time() const noexcept override;
  Status problem() const override;

 private:
  struct Message {
    DeviceSample sample;
    uint64_t number = 0;
    uint64_t absences = 0;  // times it went away, however briefly
  };
  struct Force {
    dvec3 newtons{0}, newton_metres{0};
    uint64_t number = 0;
    uint64_t seen = 0;  // the newest pose that the loop had
  };

  void Run();
  void Serve();
  std::unique_ptr<PolledBus> Reopened();
  Status CheckReopened(const Result<std::unique_ptr<PolledBus>>& opened);
  Status CheckUnit(const PolledBus& bus) const;
  Status CheckPlace(PolledBus& bus);
  void Wait(std::chrono::milliseconds duration);
  void Note(const Status& problem);
  Force AwaitForce();
  bool Hear(int64_t& asked_ns);
  bool IsReached(const dvec3& tip_m);
  void Publish(bool attached);

  std::unique_ptr<PolledBus> bus_;  // the thread's
  const std::string name_, driver_, unit_;
  const bool answers_, counts_from_power_up_;
  const double resolution_m_;
  const std::function<void()> thread_setup_;
  const ReopenBus reopen_;
  TripleBuffer<Message> poses_;
  TripleBuffer<Force> forces_;
  ForceSignal force_signal_;
  std::atomic<bool> stop_{false};
  mutable Mutex mutex_;
  std::condition_variable_any stopping_;
  Status problem_ ENAMEL_GUARDED_BY(mutex_);
  std::atomic<uint64_t> samples_{0}, refused_{0}, writes_{0}, detached_{0};
  DurationHistogram answers_ns_;
  // Owned by the thread.
  ForceKeeper keeper_;
  PolledBus::Pose pose_;  // the newest
  dvec3 read_m_{0};       // the newest tip that was read, taken or not
  int agreeing_ = 0;      // poses in a row that were near the one before
  bool posed_ = false;    // since the bus was opened
  bool centred_ = false;
  bool is_lost_ = false;  // it may be elsewhere than it says
  uint64_t absences_ = 0;
  dvec3 centre_m_{0};
  int64_t heard_us_ = 0;  // when the newest exchange ended
  int64_t posed_us_ = 0;  // when the newest pose came
  uint64_t taken_ = 0;    // number of the newest force that was sent or due
  uint64_t published_ = 0;
  // Owned by the tick.
  uint64_t seen_ = 0, seen_absences_ = 0, sent_ = 0;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace enamel::station
