#pragma once

#include "common/fidelity/hands.h"
#include "common/fidelity/plant.h"

// The stiffest spring and the strongest damper a simulated device can render, found by experiment:
// bisection on the simulated device's behaviour, with its own damping b given. Uses no listed
// stiffness, so results can be compared with one. SI units.
//
// Two criteria, which differ by orders of magnitude for a damper:
//  * passive: no cyclic motion of the tip lets the operator gain energy for ever;
//  * stable: the device, alone or in a hand of given mass, stiffness and damping, comes to rest.
// Deterministic. Thread safety: all functions may be called from any thread.
namespace enamel::station::lab {

using fidelity::ImpedanceHand;
using fidelity::LineMotion;
using fidelity::Plant;
using fidelity::PlantSpec;
using fidelity::ScriptedHand;

enum class Rendered {
  kSpring,  // F = -K p, p the cell's middle
  kDamper,  // F = -B (p_i - p_{i-1}) f: eq. 1 of the paper on one tick's difference
};

// The hold on the tip: a spring and a damper to a fixed point, and a mass. All zero: none.
struct Hold {
  double mass_kg = 0, stiffness_n_per_m = 0, damping_n_s_per_m = 0;
};

// Largest K (N/m) or B (N s/m) at which none of the cyclic motions tried gains energy cycle after
// cycle: 2 to 20 ticks a cycle, as large as 10 000 cells and as small as a 500th of one across a
// cell's edge. An upper bound of the passive range (other motions might do better); theory says
// none does: min(2 b / T, 2 c / delta) and min(b, c T / delta) without delay.
double LargestPassive(const PlantSpec& plant, Rendered what);

// Largest K or B at which the tip's swings decrease: released 1 mm from the spring's rest, or after
// one false reading of 1 mm that jolts the damper. Bisection assumes one boundary; the search ends
// at 1e7. The plant's sub-steps shift it: with n sub-steps K is too high by 1/n.
double LargestStable(const PlantSpec& plant, Rendered what, const Hold& hold);

// The same boundary for the device alone from the poles of the sampled, undelayed linear system
// (mass, b, zero-order hold; no friction, no cells): exact.
double LinearStableSpring(double mass_kg, double damping_n_s_per_m, double tick_s);
double LinearStableDamper(double mass_kg, double damping_n_s_per_m, double tick_s);

}  // namespace enamel::station::lab
