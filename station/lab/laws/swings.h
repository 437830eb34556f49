#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/haptics/swing_watch.h"
#include "station/lab/laws/model.h"

// Hands on a device that is, or is not, what its profile says: whether they swing, and when the watch of
// common/haptics/swing_watch.h sees it. SI units. Deterministic. Thread safety: functions, any thread.
namespace enamel::station::lab {

// How the device differs from its profile.
struct ProfileError {
  const char* name;                            // "b/4 c/2"
  double damping = 1, friction = 1, mass = 1;  // times the profile's
  int ticks = 0;                               // of delay, beyond what the law is told
};
// The first is none.
const std::vector<ProfileError>& ProfileErrors();

enum class SwingHand {
  kPush,  // constant force in tissue, hardly damped
  kLand,  // the same, from a third of a millimetre above a surface
  kGrip,  // a spring that works a surface to and fro, with tremor
  kTap,   // a spring that taps a surface
};
inline constexpr SwingHand kSwingHands[] = {SwingHand::kPush, SwingHand::kLand, SwingHand::kGrip,
                                            SwingHand::kTap};
const char* NameOf(SwingHand hand);

struct SwingTrial {
  SwingHand hand = SwingHand::kPush;
  double mass_kg = 0.1, damping_n_s_per_m = 1;
  double push_n = 0, stiffness_n_per_m = 0;  // push, land; grip, tap
  dvec3 direction{1, 0, 0};                  // of push and strokes
  double stroke_m = 0, stroke_hz = 0;        // amplitude
  double tremor_m = 0, tremor_hz = 10;
  double b_n_s_per_m = 1000;
  bool wall = false;  // land, tap: against what does not give
  fidelity::Lattice lattice;
  haptics::OwnFriction told;  // as the law is told; the device's own may be another
  std::vector<dvec3> way_m;   // grip: instead of strokes and tremor, if any
  double seconds = 4;
};
// One drawn at random. `light`: hands that damp little, as those that swing.
SwingTrial DrawSwingTrial(SwingHand hand, const DeviceModel& model, bool light, Random& random);

// The force sent, on the operator, a tick each, without what pushes along the motion: as the watch sees it. `watched`: the watch may lower the stiffness.
std::vector<dvec3> RunSwingTrial(const DeviceModel& model, const SwingTrial& trial,
                                 const ProfileError& error, bool watched);

// Peak to peak over a tenth of a second, of the force less its mean over the same time around: when it
// passes 1 N to stay above it for half a second. No value: it never does.
std::optional<double> SwingBegins(const std::vector<dvec3>& force_n, double tick_s);
// The same measure, its largest in the last second.
double SwingLeft(const std::vector<dvec3>& force_n, double tick_s);
// When a watch that only looks is tripped by the force.
std::optional<double> SwingSeen(const std::vector<dvec3>& force_n,
                                const haptics::SwingWatchParams& watch);

}  // namespace enamel::station::lab
