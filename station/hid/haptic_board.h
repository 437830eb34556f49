#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "common/base/mutex.h"
#include "common/base/triple_buffer.h"
#include "common/scene/types.h"
#include "station/devices/device.h"
#include "station/devices/force_keeper.h"
#include "station/devices/force_signal.h"
#include "station/devices/polled_device.h"
#include "station/hid/axis_map.h"
#include "station/hid/haptic_report.h"
#include "station/hid/hid_reader.h"

namespace enamel::station::hid {

struct HapticBoardSettings {
  HidMatch match;  // any board, unless ids are given
  AxisMap axes;
  int watchdog_ms = 20;  // or the board's maximum, if that is less
  // True: the hand's position at the first report is the middle of the exercise. False: the board's
  // own zero is.
  bool centre_on_first_report = true;
  // Called at the start of each of its two threads, to give them the loop's priority.
  std::function<void()> thread_setup;
};

// Orders the reports of a board by sequence number. Pure; the schema has the rule.
class ReportOrder {
 public:
  enum class Verdict : uint8_t { kNew, kRestarted, kDuplicate, kLate };
  Verdict Judge(uint32_t sequence) noexcept;
  uint64_t lost() const noexcept { return lost_; }
  // The next report is accepted whatever its number.
  void Forget() noexcept { has_last_ = false; }

 private:
  bool has_last_ = false;
  uint32_t last_ = 0;
  uint64_t lost_ = 0;
};

// Device::Unit() of a board, without opening it: empty if it has no serial number.
std::string UnitOf(const HidInfo& info);

// A haptic board that speaks schemas/hid_haptic_report.md.
//
//   reader thread:  hid_read ─▶ checked, ordered ─▶ latest sample ─▶ ReadSample     (tick)
//   writer thread:  hid_write ◀─ ForceKeeper ◀─ latest force ◀─ semaphore ◀─ SendForce (tick)
//
// Each thread has its own handle, so a write that blocks delays neither reading nor the tick; the
// next write sends the newest force. The reader searches for an unplugged board until it returns;
// force returns in free air once it is back. A board that returns as another device
// (another serial number, or a different feature report) is not accepted. It is asked again every
// HidReader::kRetry, since a newly plugged board may not answer yet.
//
// Events that make its poses untrustworthy (unplugged, not fit, restarted: the encoders may have
// lost their zero) reach the tick at least once as `attached` false, however brief. A board that restarted
// or was plugged in again, and first says that it is fit more than kFar_m from where it was last, stays so
// until it has said that it is not fit, as while it is homed; problem() says why. A board that
// switches its motors off, or whose watchdog does, reaches it as `driven` false.
//
// Thread safety: ReadSample and SendForce by the tick's thread, counters by any. Real-time: those
// are safe (SendForce posts a semaphore at most once per write). The destructor sends force 0,
// motors off.
class HapticBoard final : public MotorDevice, private ReportSink {
 public:
  // Opens the board, asks for its feature report and waits for its first report. Errors: kNotFound
  // with what is attached, kUnavailable (may not be opened, silent), kVersion, kInvalidInput (its
  // answer).
  static Result<std::unique_ptr<HapticBoard>> Open(const HapticBoardSettings& settings);
  ~HapticBoard() override;

  const FeatureReport& feature() const noexcept { return feature_; }

  std::string Name() const override { return name_; }
  std::string Unit() const override { return unit_; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, name_, "hid", unit_); }
  ENAMEL_REALTIME DeviceSample ReadSample() noexcept override;
  // Torque goes to a board that reports six driven axes, and is dropped otherwise.
  ENAMEL_REALTIME void SendForceAndTorque(const dvec3& force_n,
                                          const dvec3& torque_n_m) noexcept override;
  bool runs_spring() const noexcept override { return feature_.runs_spring(); }
  // Written once. A board without news lets the force fall by its own rule (the schema's "Lost host"),
  // so that no keeper repeats it.
  ENAMEL_REALTIME void SendSpring(const SpringCommand& command) noexcept override;
  DeviceCounters counters() const noexcept override;
  Status problem() const override;

  // About as far as a hand moves while a cable is out for a moment.
  static constexpr double kFar_m = PolledDevice::kFar_m;

 private:
  struct Pose {
    DeviceSample sample;
    uint64_t number = 0;
    uint64_t breaks = 0;       // times its poses became untrustworthy
    uint64_t switch_offs = 0;  // reports in which it had switched its force off by itself
  };
  // What the tick sent last: a force with its torque, or a command to the board's spring.
  struct Force {
    dvec3 newtons{0}, newton_metres{0};  // scene axes
    uint64_t number = 0;
    bool to_spring = false;
    SpringCommand spring;
  };

  HapticBoard(const HapticBoardSettings& settings, const HidInfo& info, FeatureReport feature);
  void OnReport(ByteView bytes) override;
  bool OnAttached(const HidInfo& info) override;
  void OnDetached() override;
  void PublishPose(bool fresh);
  void TakeReport(const InputReport& report);
  bool SwitchedOff(uint8_t status);
  void JudgePlace(const InputReport& report);

  void Write();
  void Post(const Force& force) noexcept;
  bool Send(HidPort& port, const ForceKeeper::Command& command, uint32_t sequence);
  bool Send(HidPort& port, SpringCommand command, uint32_t sequence);
  bool Put(HidPort& port, ByteView report, bool motors_on);
  int64_t MiddleNm(size_t board_axis) const noexcept;  // centre_, from where its counts are 0
  void TakePort(std::unique_ptr<HidPort>& port);

  const HapticBoardSettings settings_;
  const FeatureReport feature_;
  const std::string serial_, name_, unit_;
  const int watchdog_ms_;
  TripleBuffer<Pose> poses_;
  TripleBuffer<Force> forces_;
  std::atomic<bool> stop_{false}, attached_{false};
  std::atomic<bool> misplaced_{false};       // it may be elsewhere than it says
  std::atomic<int64_t> first_driven_us_{0};  // 0: its motors were never requested
  std::atomic<uint32_t> turns_{0};  // how often its motors were requested; odd while they are
  std::atomic<uint64_t> samples_{0}, lost_{0}, duplicated_{0}, refused_{0}, writes_{0},
      write_errors_{0}, detached_{0};

  // Owned by the reader's thread.
  DeviceSample sample_;
  uint64_t published_ = 0, breaks_ = 0, switch_offs_ = 0;
  uint32_t seen_turns_ = 0;
  bool said_on_ = false;   // since the last turn: its motors are on
  bool said_fed_ = false;  // since they were first requested: its watchdog is content
  ReportOrder order_;
  bool centred_ = false;
  bool must_be_near_ = false;         // the next report: it restarted, or was plugged in again
  std::array<int32_t, 3> trusted_{};  // counts of the newest report that was fit and in its place
  // The board's counts at the scene's middle. Constant from the first report on, which Open awaits: the
  // other threads may read it.
  std::array<int32_t, 3> centre_{};
  uint32_t last_time_us_ = 0;
  bool new_clock_ = false;  // the next report's time is unrelated to the last one's

  // Owned by the tick.
  uint64_t seen_ = 0, seen_breaks_ = 0, seen_switch_offs_ = 0, sent_ = 0;

  ForceSignal force_signal_;
  Mutex port_mutex_;
  std::unique_ptr<HidPort> new_port_ ENAMEL_GUARDED_BY(port_mutex_);  // for the writer to take
  std::thread writer_;
  std::unique_ptr<HidReader> reader_;  // made last, ended first
};

// Reads an open board's feature report. Errors: kUnavailable, kVersion, kInvalidInput.
Result<FeatureReport> AskFeature(HidPort& port);

// Checks that the board can carry an attempt with this profile at this tick rate. Its cells must
// have the profile's edge on every axis, because the core computes with that. It must send its pose
// in every tick: an older pose is delay, for which Kc is too stiff. Its motors must reach the peak
// force of the profile. If the profile has torque, the board must drive six axes and report its
// orientation. Errors: kConflict with both figures.
Status CheckBoard(const FeatureReport& board, const scene::DeviceProfile& profile,
                  uint32_t rate_hz);

}  // namespace enamel::station::hid
