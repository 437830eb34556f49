#pragma once

#include "station/lab/laws/model.h"
#include "station/lab/laws/motions.h"

// One motion of a hand in one uniform tissue on one device, and how well the law follows F = B v.
namespace enamel::station::lab {

struct HandTrial {
  haptics::LawKind law = haptics::kDefaultLaw;
  double b_n_s_per_m = 6500;
  HandKind hand = HandKind::kVelocity;   // kVelocity prescribes the way; the others: see below
  double hand_stiffness_n_per_m = 1000;  // kImpedance: of the spring to the way
  double hand_mass_kg = 0.1;
  Lattice lattice;
  int delay_ticks = 0;
};

// v is the motion's speed if the tip is prescribed; else the tip's own, smoothed over 10 ms.
struct HandFigures {
  double ideal_rms_n = 0;    // RMS of B v
  double error_rms_n = 0;    // RMS of R - B v
  double oracle_rms_n = 0;   // the same of the oracle: what rises by at most Kc |v| T in a tick
  double lag_s = 0;          // at which R and B v correlate best, within 1.5 s
  double help_s = 0;         // how long after a reversal the force pushes the hand along
  double excess_n = 0;       // most that one axis of R has beyond B v along the motion ...
  double overshoot = 0;      // ... and that the force along the motion has, over B v's largest
  double direction_deg = 0;  // mean angle between R and v, after the first second
  double trail_m = 0;        // RMS distance from the bur to the tip
  double step_n = 0;         // most that a step of R has beyond Kc (|dx| + sqrt(3) delta)
  double energy_min_j = 0;   // of the theorem's balance; never below 0 where it holds
};

// Deterministic. Thread safety: any thread.
HandFigures RunHand(const DeviceModel& model, const HandTrial& trial, const HandMotion& motion);

}  // namespace enamel::station::lab
