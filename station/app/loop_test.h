#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

struct LoopTestCommand {
  int seconds = 60;
  int rate_hz = 1000;
  int cpu = -1;  // -1: not bound
  std::filesystem::path json;
};

// Measures the haptic loop's own cost and its punctuality on this machine, and prints method and
// figures:
//
//   Own cost: ticks of the loop (mouse device in free air, recording drained) against the core
//   alone on the same inputs, in alternating batches; the difference of their means.
//   Lateness: a bare absolute sleep at the rate and the whole loop alternate every 5 s, on threads
//   set up alike, with the recorder draining during both. Compares actual with intended wake-up:
//   quantiles, the share late by a whole period or more (each a tick the hand did not have), and
//   the shares by steps of lateness.
//
// Errors: kInvalidInput for less than two turns of each, or a rate outside 100 Hz to 20 kHz.
Status TestLoop(const LoopTestCommand& options);

}  // namespace enamel::station
