#pragma once

#include <vector>

#include "common/fidelity/felt.h"

// Splits the error of the force in a hand by cause.
//
// The device becomes real in steps, from the ideal tool to what it is, and the force in the hand is simulated
// in each (felt.h). What a step changes is charged to its cause. The steps' differences add up to the error
// in every tick, whatever their order; the order is the one in which the causes act on each other:
//
//   saturation    the motors' ceiling
//   inertia       the device's mass
//   damping       its own b
//   friction      its own c
//   lag           the spring Kc between tip and bur in place of the damper itself: plain Maxwell, exact
//                 positions, eight times the rate
//   law           what the law at its rate makes of that spring; below 0 where it takes lag away
//   quantisation  the encoder's cells and noise
//   delay         ticks from reading to force
//
// Deterministic. SI units. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::fidelity {

struct FeltPart {
  const char* cause;
  double rms_n = 0, p95_n = 0;  // of what the step changes
  double share = 0;             // of the error's mean square; they add up to 1
};

struct FeltBudget {
  std::vector<FeltPart> parts;                  // in the order above
  double rms_n = 0, p95_n = 0, tool_rms_n = 0;  // of the error, and of the tool's force
};

// Requires: as `Feel`, and a spring on the host (`device.board.ticks` 0).
FeltBudget BudgetOf(const FeltDevice& device, const FeltTrial& trial,
                    const std::vector<dvec3>& way_m);

}  // namespace enamel::fidelity
