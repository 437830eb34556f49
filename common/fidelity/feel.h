#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "common/fidelity/felt.h"

// The map of what a hand can feel: up to which stiffness of its grip a device passes for tissue that
// resists with F = B v, within what a hand can tell.
//
// A hand gives. The spring Kc between tip and bur is in series with it, so a soft grip hides a soft device.
// Each point of the map is simulated (felt.h): a hand that works a surface, in uniform tissue, with the
// device's mass, damping, friction, cells, delay and the ceiling of its motors. The error is of the force in
// the hand, against that on an ideal tool: what a hand gets of F = B v. Friction and inertia of a device are
// force too, and no law takes them away. Beside it the closed form of the spring alone.
// Not in it: the shape of a cut, the bur's axial B, the motors' heating.
//
// Deterministic. SI units. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::fidelity {

// The smallest differences that a hand feels, as shares of the right value and as a time. The
// published figures are for trained hands in a laboratory that look for the difference: within them
// nobody feels one. Force: Jones 1989 (Perception 18:681), 7 %; Pang, Tan and Durlach 1991
// (Perception & Psychophysics 49:531), 5 to 10 %.
inline constexpr double kForceShare = 0.07;
// Viscosity: Jones, Hunter and Lafontaine 1997 (Perception 26:1571), 19 % between 4 and 512 N s/m.
// Tooth tissue is up to 22 times above that range; the figure is taken to hold there as well.
inline constexpr double kViscosityShare = 0.19;
// What a map is drawn for. The one in the middle is no threshold: twice the first, it shows how steep the
// way between the two is.
inline constexpr double kShares[] = {kForceShare, 0.15, kViscosityShare};
// Delay of a damper's force: Rank, Shi, Mueller and Hirche 2010 (EuroHaptics, LNCS 6191), noticed
// from 15 ms.
inline constexpr double kDelay_s = 0.015;

// Grips of the map. A hand's is 0.3 (loose) to 2 N/mm (firm); beyond, a finger rest takes part of the force.
inline constexpr double kGrips_n_per_m[] = {300,  500,  700,  1000,   1400,  2000,
                                            3000, 5000, 7000, 10'000, 20'000};
// How quickly a hand that works a surface moves to and fro: what the closed form needs of a motion
// (common/haptics/README.md, "The law").
inline constexpr double kHand_rad_per_s = 1.6;

// One point of the map: RMS error over RMS force, both over all ways. Requires: a grip above 0; at least one
// way, as `Feel` asks.
double FeltIn(const FeltDevice& device, const FeltTrial& trial, double grip_n_per_m,
              std::span<const std::vector<dvec3>> ways_m);

// The stiffest grip up to which `errors` (one for each of `grips`, which rise) stay within `share`: straight
// lines between the points, over the logarithm of the grip. 0 where the softest is beyond it already; the
// stiffest where none is.
double StiffestGrip(std::span<const double> grips_n_per_m, std::span<const double> errors,
                    double share);

}  // namespace enamel::fidelity
