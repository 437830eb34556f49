#pragma once

#include <filesystem>

#include "common/base/result.h"

namespace enamel::station {

struct LoopTestCommand {
  int seconds = 60;
  int rate_hz = 1000;
  int cpu = -1;  // -1: not bound to one
  std::filesystem::path json;
};

// Measures what the haptic loop itself costs and how punctual it is here, prints method and
// figures:
//
//   Own cost: ticks of the loop (mouse device in free air, recording drained) against the core
//   alone on the same inputs, in alternating batches; the difference of their means.
//   Lateness: a bare absolute sleep at the rate and the whole loop take turns every 5 s, on threads
//   made alike, with the recorder's draining at work during both. What is compared is the moment
//   they wake against the moment they meant to: quantiles, the share late by a whole period or more
//   (each a tick the hand did not have), and the shares by steps of lateness.
//
// Errors: kInvalidInput for less than two turns of each, or a rate outside 100 Hz to 20 kHz.
Status TestLoop(const LoopTestCommand& options);

}  // namespace enamel::station
