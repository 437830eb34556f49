#pragma once

#include <string>
#include <vector>

#include "common/fidelity/hands.h"
#include "common/fidelity/plant.h"
#include "common/haptics/coupling.h"

// One simulated cut with one law on one device in one hand, and its measurements.
namespace enamel::station::lab {

using fidelity::CellMiddle;
using fidelity::ForceHand;
using fidelity::Grip;
using fidelity::Hand;
using fidelity::ImpedanceHand;
using fidelity::Lattice;
using fidelity::LineMotion;
using fidelity::Plant;
using fidelity::PlantSpec;
using fidelity::Random;
using fidelity::VelocityHand;

enum class HandKind { kVelocity, kForce, kImpedance };

// The same material everywhere, or changing with the anchor's way along the trial's direction.
struct TissueStep {
  double at_s = 0;  // from this time on
  double b_n_s_per_m = 0;
};

struct TrialSpec {
  PlantSpec plant;
  haptics::LawParams law;
  double peak_force_n = 1e9;       // bound of the output chain
  Sym3 b_n_s_per_m;                // damping of the material
  std::vector<TissueStep> tissue;  // replaces b (isotropic), in time order
  HandKind hand = HandKind::kVelocity;
  double hand_stiffness_n_per_m = 1000;
  double hand_mass_kg = 0.1;
  double hand_damping_n_s_per_m = 2;
  dvec3 direction{1, 0, 0};        // unit
  double speed_m_per_s = 0.43e-3;  // the force hand pushes with B v
  double tremor_m = 0, tremor_hz = 10;
  double reverse_s = -1;
  dvec3 start_offset_m{3.3e-6, 2.1e-6, 1.1e-6};  // where in its cell the tip starts
  double settle_s = 0;                           // 0: SettleTime
  double window_s = 2;                           // steady figures are taken over this
  bool measure_release = true;                   // wait after the stop, at most until 120 s
  double trace_s = 0;                            // > 0: keep a sample that often
};

struct Sample {
  double t_s = 0, force_n = 0, tip_m = 0, anchor_m = 0;  // along the direction
};

struct Measurement {
  double target_n = 0;     // B v along the direction
  double mean_n = 0;       // resisting force along the direction, in the window
  double error_max_n = 0;  // largest per axis |R_i - (B v)_i| in the window (velocity hand)
  double error_rms_n = 0;  // of the vector R - B v
  // In the hand: of the vector R_hand - B V, R_hand with the device's friction, damping and inertia, V the
  // slope of the line fitted through the tip's way in the window: RMS, and what 95 % of the ticks are within.
  double felt_error_rms_n = 0, felt_error_p95_n = 0;
  // Force and impedance hands: largest per axis |B V_anchor - R|, V_anchor the slope fitted through
  // the anchor's way and R the mean over the window; it is their error_max.
  double anchor_error_n = 0;
  double ripple_rms_n = 0;       // about the mean, along the direction
  double ripple_fast_rms_n = 0;  // the part above 20 Hz
  double deviation_m = 0;  // tip's largest distance from its fitted line x0 + v t in the window
  double rise90_s = -1, rise90_floor_s = 0;
  // Time from the stop until |R| <= 10 % of the mean, or until every axis holds no more than the
  // guard may leave, Kc delta / 2; -1: never. Not measured with a force hand.
  double release10_s = -1, release_level_n = 0;
  double kick_n = 0;  // largest force against the hand's return after the stop
  double energy_min_j = 0,
         energy_floor_j = 0;  // sum of R dx + b/T dx^2 + c |dx|, and its proved floor
  double handed_j = 0;        // sum of R dx: what the operator put in and the motors took
  double extracted_j = 0;     // most energy the operator got out: -(lowest sum of R dx) alone
  bool violation = false;     // energy under the floor by more than rounding
  bool cycle = false;
  bool unstable = false;  // not finite, or the force swings between its limits
  int ticks = 0;
  std::vector<Sample> trace;
};

// Time after which the steady window starts: when the plain coupling's transient, B (1/Kc +
// 1/k_hand), is down to 1 %, within 120 s of simulated time for the whole trial.
double SettleTime(const TrialSpec& spec);

// Deterministic: equal specs give equal measurements. Thread safety: any thread.
Measurement RunTrial(const TrialSpec& spec);

// Largest difference of the tip's way over the trial between this spec's sub-steps and eight times
// as many, with the motor force replayed from the coarse run, m.
double IntegrationError(const TrialSpec& spec);

}  // namespace enamel::station::lab
