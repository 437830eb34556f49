#pragma once

#include <string>
#include <vector>

#include "common/scene/types.h"

// Whether a device profile can be worked with stably, criterion by criterion, with the figures
// (common/haptics/criteria.h has the formulas and their sources). The plan refuses a profile by the
// same conditions at an exercise's rate; this is at the profile's own.
// Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

// One condition: `value` must not be above `limit`, or, with `at_least`, not below it.
struct ProfileCriterion {
  std::string name;     // stable: "coupling_damping"
  std::string title;    // for people
  std::string formula;  // as in criteria.h
  std::string unit;
  std::string member;  // of the profile, what to change first
  double value = 0, limit = 0;
  bool at_least = false;
  bool met = true;
};

// In a fixed order:
//   coupling_damping    Kc <= 2 b/(T (d + 1)^2), the coupling's passive limit
//   coupling_friction   c >= Kc delta/2, what the coupling's theorem asks of the friction
//   coupling_stiffness  Kc <= K, the largest stiffness the device shows stably
//   continuous_force    continuous force <= peak force
// and where the profile has torque (rho: orientation_cell_urad)
//   torque_damping      K <= 2 b_rot/(T (d + 1)^2)
//   torque_friction     c_rot >= K rho
//   torque_peak         peak torque >= 2 K rho, or the bur could not follow the hand in air
// b is the device's own and the electrical damping.
std::vector<ProfileCriterion> CheckProfile(const DeviceProfile& profile);

// Every one is met.
bool IsAcceptable(const std::vector<ProfileCriterion>& criteria);

}  // namespace enamel::scene
