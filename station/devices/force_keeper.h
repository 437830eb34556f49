#pragma once

#include <cstdint>
#include <optional>

#include "common/math/vec.h"

namespace enamel::station {

// Decides what a writer thread sends to a board, and when. Keeps the board's watchdog fed without
// keeping an old force alive: a force that the loop has not renewed for kHold_us falls linearly to
// 0, kGone_us after its time. From then on the repeats send 0. During the fall, repeats come at
// least every kHold_us, whatever the watchdog's time, and one comes at kGone_us, so that the board
// then holds 0. Time is a parameter: no clock. Thread safety: none. Real-time: safe.
class ForceKeeper {
 public:
  static constexpr int64_t kHold_us = 5'000, kGone_us = 20'000;

  // Repeats come four times per watchdog time.
  explicit ForceKeeper(int watchdog_ms) : repeat_us_(int64_t{watchdog_ms} * 250) {}

  struct Command {
    dvec3 force_n{0};
    dvec3 torque_n_m{0};     // falls with the force
    bool motors_on = false;  // false before the first force and once it has gone
  };

  // The loop's newest force; `number` counts its forces, 0: none yet. If either is not finite, both
  // are 0.
  void Take(const dvec3& force_n, uint64_t number, int64_t now_us,
            const dvec3& torque_n_m = dvec3(0)) noexcept;
  // The command to send now: a new force or a repeat that is due; or nothing.
  std::optional<Command> Next(int64_t now_us) noexcept;
  // How long to wait for a new force before the next call of Next.
  int64_t WaitFor_us(int64_t now_us) const noexcept;

 private:
  int64_t Due_us() const noexcept;  // of the next repeat

  const int64_t repeat_us_;
  dvec3 force_n_{0}, torque_n_m_{0};
  uint64_t number_ = 0;
  int64_t taken_us_ = 0, sent_us_ = 0;
  bool unsent_ = false;
};

}  // namespace enamel::station
