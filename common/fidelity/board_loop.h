#pragma once

#include <deque>

#include "common/board/board.h"
#include "common/haptics/coupling.h"

// A coupling whose spring runs on the device's board: the law in the host's ticks, the reference
// firmware (common/board/board.h) in its own, and the way of the reports between them.
// Deterministic. Thread safety: none. Real-time: not safe.
namespace enamel::fidelity {

struct BoardSpec {
  int ticks = 0;            // of the board in a tick of the host; 0: the host runs the spring
  int delay_ticks = 1;      // of the board: from reading to force
  int late_host_ticks = 1;  // from the report that the host answers to the answer's arrival
};

class BoardLoop {
 public:
  // `params` as for a coupling that runs its own spring: tick and Kc, delay not used. `damping`: b.
  // Requires: Kc within what b pays for at the board's tick and delay.
  BoardLoop(haptics::CouplingParams params, const BoardSpec& spec, double damping_n_s_per_m);

  void Reset(const dvec3& tip_m);
  // One tick of the board at this reading: the force on the operator.
  dvec3 Tick(const dvec3& tip_m, haptics::Material& material);

 private:
  void AskHost(const dvec3& tip_m, haptics::Material& material);

  haptics::CouplingParams params_;
  const BoardSpec spec_;
  haptics::Coupling coupling_;
  EnBoard board_{};
  std::deque<EnCommand> under_way_;
  int until_host_ = 0;
  uint32_t sequence_ = 0;
};

}  // namespace enamel::fidelity
