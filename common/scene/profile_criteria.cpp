#include "common/scene/profile_criteria.h"

#include <algorithm>

#include "common/haptics/criteria.h"

namespace enamel::scene {
namespace {

// The profile in SI units.
struct Si {
  explicit Si(const DeviceProfile& profile)
      : kc(static_cast<double>(profile.coupling_mn_per_mm.value)),  // mN/mm = N/m
        k(static_cast<double>(profile.max_stiffness_mn_per_mm.value)),
        b(static_cast<double>(profile.damping_mn_s_per_m.value) * 1e-3),
        c(static_cast<double>(profile.friction_mn.value) * 1e-3),
        delta(static_cast<double>(profile.resolution_nm.value) * 1e-9),
        tick(1.0 / static_cast<double>(profile.rate_hz.value)),
        delay(static_cast<int>(profile.bus_delay_ticks.value)) {}
  double kc, k, b, c, delta, tick;
  int delay;
};

// Profiles are whole numbers: what is equal on paper is not to be refused for a rounding.
constexpr double kRounding = 1e-9;

ProfileCriterion Judged(ProfileCriterion criterion) {
  double slack = kRounding * criterion.limit;
  criterion.met = criterion.at_least ? criterion.value >= criterion.limit - slack
                                     : criterion.value <= criterion.limit + slack;
  return criterion;
}

}  // namespace

std::vector<ProfileCriterion> CheckProfile(const DeviceProfile& profile) {
  Si si(profile);
  double passive = haptics::CouplingStiffness(si.b, si.tick, si.delay);
  return {
      Judged({"coupling_damping", "Passive limit of the coupling", "Kc <= 2 b/(T (d + 1)^2)", "N/m",
              "coupling_mn_per_mm", si.kc, passive}),
      Judged({"coupling_friction", "Friction that pays for the encoder's cell", "c >= Kc delta/2",
              "N", "friction_mn", si.c, haptics::CouplingFriction(si.kc, si.delta), true}),
      Judged({"coupling_stiffness", "Largest stiffness the device shows", "Kc <= K", "N/m",
              "coupling_mn_per_mm", si.kc, si.k}),
      Judged({"continuous_force", "Continuous force within the peak", "Fcont <= Fpeak", "N",
              "continuous_force_mn", static_cast<double>(profile.continuous_force_mn.value) * 1e-3,
              static_cast<double>(profile.peak_force_mn.value) * 1e-3}),
  };
}

bool IsAcceptable(const std::vector<ProfileCriterion>& criteria) {
  return std::ranges::all_of(criteria, &ProfileCriterion::met);
}

}  // namespace enamel::scene
