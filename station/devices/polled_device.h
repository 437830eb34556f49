#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

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

// Of the times between questions and whole answers.
scene::AnswerTime AnswerTimeOf(const DurationHistogram& answers_ns) noexcept;

// Runs a polled device on its own thread, as fast as its bus allows, and exchanges the newest
// values with the tick. A device that only answers has one exchange for each tick in which the loop has
// seen its last answer, and one each millisecond while the loop is silent. A force that the loop has not renewed falls to 0 (ForceKeeper).
// A pose that is not finite is left out and counted as refused. Once detached it stays detached, with
// force 0.
// Real-time: ReadSample and the Sends are safe. The destructor sends 0.
class PolledDevice final : public MotorDevice {
 public:
  // `resolution_m`: edge of a count, from the device profile. The first pose read is the centre.
  // `thread_setup` is called when the thread begins; it may be empty.
  PolledDevice(std::unique_ptr<PolledBus> bus, double resolution_m,
               std::function<void()> thread_setup = {});
  ~PolledDevice() override;

  std::string Name() const override { return name_; }
  std::string Unit() const override { return unit_; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, name_, driver_, unit_); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override;
  DeviceCounters counters() const noexcept override;
  std::optional<scene::AnswerTime> answer_time() const noexcept override;

 private:
  struct Message {
    DeviceSample sample;
    uint64_t number = 0;
  };
  struct Force {
    dvec3 newtons{0}, newton_metres{0};
    uint64_t number = 0;
    uint64_t seen = 0;  // the newest pose that the loop had
  };

  void Run();
  Force AwaitForce(const ForceKeeper& keeper);
  bool Hear(PolledBus::Pose& pose, int64_t& asked_ns);
  void Publish(const PolledBus::Pose& pose, bool attached);

  const std::unique_ptr<PolledBus> bus_;
  const std::string name_, driver_, unit_;
  const bool answers_;
  const double resolution_m_;
  const std::function<void()> thread_setup_;
  TripleBuffer<Message> poses_;
  TripleBuffer<Force> forces_;
  ForceSignal force_signal_;
  std::atomic<bool> stop_{false};
  std::atomic<uint64_t> samples_{0}, refused_{0}, writes_{0}, detached_{0};
  DurationHistogram answers_ns_;
  // Owned by the thread.
  dvec3 centre_m_{0};
  int64_t heard_us_ = 0;
  uint64_t taken_ = 0;  // number of the newest force that was sent or due
  uint64_t published_ = 0;
  // Owned by the tick.
  uint64_t seen_ = 0, sent_ = 0;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace enamel::station
