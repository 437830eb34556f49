#pragma once

#include <semaphore.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>

#include "common/base/triple_buffer.h"
#include "common/scene/types.h"
#include "station/devices/device.h"
#include "station/devices/force_keeper.h"
#include "station/hid/axis_map.h"
#include "station/hid/haptic_report.h"
#include "station/hid/hid_reader.h"

namespace enamel::station::hid {

struct HapticBoardSettings {
  HidMatch match;  // any board, unless its ids are given
  AxisMap axes;
  int watchdog_ms = 20;  // or what the board accepts, if that is less
  // Where the hand is when the first report comes is the middle of the exercise. False: the board's
  // own zero is.
  bool centre_on_first_report = true;
  // Called at the start of each of its two threads: to give them the loop's priority.
  std::function<void()> thread_setup;
};

// Orders the reports of a board by their sequence numbers. Pure; see the schema for the rule.
class ReportOrder {
 public:
  enum class Verdict : uint8_t { kNew, kRestarted, kDuplicate, kLate };
  Verdict Judge(uint32_t sequence) noexcept;
  uint64_t lost() const noexcept { return lost_; }
  // The next report is taken whatever its number.
  void Forget() noexcept { has_last_ = false; }

 private:
  bool has_last_ = false;
  uint32_t last_ = 0;
  uint64_t lost_ = 0;
};

// Device::Unit() of a board, without opening it: empty where it has no serial number.
std::string UnitOf(const HidInfo& info);

// A haptic board that speaks schemas/hid_haptic_report.md.
//
//   reader thread:  hid_read ─▶ checked, ordered ─▶ latest sample ─▶ ReadSample     (tick)
//   writer thread:  hid_write ◀─ ForceKeeper ◀─ latest force ◀─ semaphore ◀─ SendForce (tick)
//
// Each thread has a handle of its own, so a write that blocks holds up neither reading nor the
// tick; what it then writes is the newest force. An unplugged board is looked for until it is back;
// the loop's fault stays latched until the operator acts. One that comes back as another device
// (another serial number, or its feature report says anything else) is not taken; it is asked again
// every HidReader::kRetry, since a board that has just been plugged in may not answer yet.
//
// What ends the trust in its poses (unplugged, not fit, restarted: the encoders may have lost their
// zero) is told to the tick once at least, as `attached` false, however soon it is over; so is, as
// `driven` false, that it has switched the motors off or that its watchdog has.
//
// Thread safety: ReadSample and SendForce by the tick's thread, counters by any. Real-time: those
// are safe (SendForce posts a semaphore at most once per write). Destruction sends force 0, motors
// off.
class HapticBoard final : public MotorDevice, private ReportSink {
 public:
  // Opens the board, asks what it is and waits for its first report. Errors: kNotFound with what is
  // attached, kUnavailable (may not be opened, silent), kVersion, kInvalidInput (its answer).
  static Result<std::unique_ptr<HapticBoard>> Open(const HapticBoardSettings& settings);
  ~HapticBoard() override;

  const FeatureReport& feature() const noexcept { return feature_; }

  std::string Name() const override { return name_; }
  std::string Unit() const override { return unit_; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, name_, "hid", unit_); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  // The torque goes to a board that says it drives six axes, and is left out otherwise.
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override;
  DeviceCounters counters() const noexcept override;

 private:
  struct Pose {
    DeviceSample sample;
    uint64_t number = 0;
    uint64_t breaks = 0;       // so often the trust in the poses has ended
    uint64_t switch_offs = 0;  // in so many reports it had switched its force off by itself
  };
  struct Force {
    dvec3 newtons{0}, newton_metres{0};  // scene axes
    uint64_t number = 0;
  };

  HapticBoard(const HapticBoardSettings& settings, const HidInfo& info, FeatureReport feature);
  void OnReport(ByteView bytes) override;
  bool OnAttached(const HidInfo& info) override;
  void OnDetached() override;
  void PublishPose(bool fresh);
  void TakeReport(const InputReport& report);
  bool SwitchedOff(uint8_t status);

  void Write();
  bool Send(HidPort& port, const ForceKeeper::Command& command, uint32_t sequence);
  void TakePort(std::unique_ptr<HidPort>& port);
  bool WaitForForce(int64_t timeout_us);

  const HapticBoardSettings settings_;
  const FeatureReport feature_;
  const std::string serial_, name_, unit_;
  const int watchdog_ms_;
  TripleBuffer<Pose> poses_;
  TripleBuffer<Force> forces_;
  std::atomic<bool> stop_{false}, attached_{false};
  std::atomic<int64_t> first_driven_us_{0};  // 0: its motors were never asked for
  std::atomic<uint32_t> turns_{0};  // of asking for its motors, and no more: odd while it is asked
  std::atomic<uint64_t> samples_{0}, lost_{0}, duplicated_{0}, refused_{0}, writes_{0},
      write_errors_{0}, detached_{0};

  // Owned by the reader's thread.
  DeviceSample sample_;
  uint64_t published_ = 0, breaks_ = 0, switch_offs_ = 0;
  uint32_t seen_turns_ = 0;
  bool said_on_ = false;   // since the last turn: its motors are on
  bool said_fed_ = false;  // since they were first asked for: its watchdog is content
  ReportOrder order_;
  bool centred_ = false;
  std::array<int32_t, 3> centre_{};
  uint32_t last_time_us_ = 0;
  bool new_clock_ = false;  // the next report's time has nothing to do with the last one's

  // Owned by the tick.
  uint64_t seen_ = 0, seen_breaks_ = 0, seen_switch_offs_ = 0, sent_ = 0;

  std::atomic<bool> force_waits_{false};
  sem_t force_posted_;
  std::mutex port_mutex_;
  std::unique_ptr<HidPort> new_port_;  // guarded by port_mutex_: for the writer to take
  std::thread writer_;
  std::unique_ptr<HidReader> reader_;  // made last, ended first
};

// Asks an open board what it is. Errors: kUnavailable, kVersion, kInvalidInput.
Result<FeatureReport> AskFeature(HidPort& port);

// Whether the board can carry an attempt with this profile at this rate of ticks: its cells must
// have the profile's edge on every axis, since that is what the core computes with; it must say
// where it is in every tick, since a pose that is older is delay, for which Kc is too stiff; and
// its motors must reach the peak force that the profile promises; where the profile has torque, it
// must drive six axes and say how it is turned. Errors: kConflict with both figures.
Status CheckBoard(const FeatureReport& board, const scene::DeviceProfile& profile,
                  uint32_t rate_hz);

}  // namespace enamel::station::hid
