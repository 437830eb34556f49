#pragma once

#include "station/lab/laws/model.h"

// A hand cuts sideways into a wall of tissue, then lifts the bur off while its grip relaxes. Nothing is
// ahead of the lift, so nothing may hold it, and a hand that lets go must not be thrown back. SI units.
namespace enamel::station::lab {

struct Lift {
  haptics::LawKind law = haptics::kDefaultLaw;
  double hand_n_per_m = 1000;  // while it cuts
  double speed_m_per_s = 10e-3;
  double relax_s = 0.15;  // the grip's stiffness falls as exp(-t/relax_s), to a twentieth
  bool upward = false;    // lifts along the wall; else straight back from it
  double b_n_s_per_m = 6500, cut_m_per_s = 0.43e-3;
};

struct LiftFigures {
  double cut_n = 0;   // force before the lift
  double pull_n = 0;  // largest part of the force against the lift, while the tip moves with it
  // How often the force rises again by more than max(0.15 N, 2 Kc delta) from its lowest since the lift
  // began or since it last fell by as much. From 2 on the hand was thrown back and came again.
  int rises = 0;
};

// Deterministic. Thread safety: any thread.
LiftFigures RunLift(const DeviceModel& model, const Lift& lift);
// 72 of them: four grips, three speeds, three times of relaxing, back and up.
std::vector<Lift> AllLifts(haptics::LawKind law);

}  // namespace enamel::station::lab
