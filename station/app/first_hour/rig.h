#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>

#include "station/app/measured_device.h"

namespace enamel::station::first_hour {

// How far the motors may go in one push.
struct PushLimits {
  double most_n = 0;
  // Above this, or farther than this from where the push began, the force ends.
  double fastest_m_per_s = 0, farthest_m = 0;
};

// The loop of the first hour: reads the unit once a tick and sends it a force, which is 0 but within a
// push. The force of a push ends, and stays 0, when the handle is too fast or too far, when the unit is
// unplugged, silent for 20 ms or switches off by itself, and when the program is asked to stop. The
// destructor sends 0. Thread safety: none.
class Rig {
 public:
  // `by_clock`: a tick takes tick_s; else it takes no time, and the time is the ticks'. `stop`
  // (StopsAsked) is above 0 once the program has to end.
  Rig(double tick_s, bool by_clock, const std::atomic<int>& stop);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // Closes the unit before, if there is one.
  void Hold(MeasuredDevice unit);
  // Force 0, then closed.
  void Close();
  bool has_unit() const { return unit_.has_value(); }
  const MeasuredDevice& unit() const { return *unit_; }

  // Seconds since construction.
  double now_s() const;
  double tick_s() const { return tick_s_; }
  bool is_stopped() const { return stop_ > 0; }

  void BeginPush(const PushLimits& limits);
  void EndPush();
  // One tick: waits for its time, reads, and sends the force. Outside of a push every force is 0.
  void Tick(const dvec3& force_n = dvec3(0)) {
    Read();
    Send(force_n);
  }
  // The same, with a force that answers the sample just read.
  template <typename ForceOf>
  void TickWith(ForceOf force_of) {
    Read();
    Send(push_ ? force_of(sample_) : dvec3(0));
  }

  // Of the last tick; the place is that of the newest fresh sample, from the counts' zero.
  const DeviceSample& sample() const { return sample_; }
  const dvec3& tip_m() const { return tip_m_; }
  double speed_m_per_s() const;
  // Since the last fresh sample.
  double silent_s() const { return static_cast<double>(stale_ticks_) * tick_s_; }
  const dvec3& sent_n() const { return sent_n_; }
  // Why the force of the last push ended; empty: it did not.
  const std::string& cut() const { return cut_; }

 private:
  void Read();
  void Send(const dvec3& force_n);
  const char* WhyCut() const;

  const double tick_s_;
  const bool by_clock_;
  const std::atomic<int>& stop_;
  std::optional<MeasuredDevice> unit_;
  int64_t began_ns_, due_ns_, ticks_ = 0;
  std::optional<PushLimits> push_;
  std::string cut_;
  DeviceSample sample_;
  dvec3 tip_m_{0}, push_from_m_{0}, sent_n_{0};
  int64_t stale_ticks_ = 0;
  // Places of the last kSpeedTicks ticks.
  static constexpr size_t kSpeedOver = 20;
  std::array<dvec3, kSpeedOver> before_m_{};
  size_t known_ = 0;
};

}  // namespace enamel::station::first_hour
