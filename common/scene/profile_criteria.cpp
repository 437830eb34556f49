#include "common/scene/profile_criteria.h"

#include <algorithm>

#include "common/haptics/criteria.h"
#include "common/scene/cell.h"
#include "common/scene/delay.h"
#include "common/scene/rate.h"

namespace enamel::scene {
namespace {

// The profile in SI units.
struct Si {
  explicit Si(const DeviceProfile& profile)
      : kc(static_cast<double>(profile.coupling_mn_per_mm.value)),  // mN/mm = N/m
        k(static_cast<double>(profile.max_stiffness_mn_per_mm.value)),
        b(static_cast<double>(profile.viscous_mn_s_per_m()) * 1e-3),
        c(static_cast<double>(profile.friction_mn.value) * 1e-3),
        tick(1.0 / static_cast<double>(profile.rate_hz.value)),
        delay(static_cast<int>(profile.bus_delay_ticks.value)) {
    const SpringTime time =
        SpringTimeOf(profile, profile.rate_hz.value, profile.bus_delay_ticks.value);
    spring_tick = 1.0 / static_cast<double>(time.rate_hz);
    spring_delay = static_cast<int>(time.delay_ticks);
  }
  double kc, k, b, c, tick, spring_tick;
  int delay, spring_delay;
};

// Profiles are whole numbers: what is equal on paper is not to be refused for a rounding.
constexpr double kRounding = 1e-9;

ProfileCriterion Judged(ProfileCriterion criterion) {
  double slack = kRounding * criterion.limit;
  criterion.met = criterion.at_least ? criterion.value >= criterion.limit - slack
                                     : criterion.value <= criterion.limit + slack;
  return criterion;
}

// The same of turning: N m and radians.
void AddTorque(const TorqueSpec& torque, const Si& si, std::vector<ProfileCriterion>& out) {
  const double k = static_cast<double>(torque.coupling_un_m_per_rad.value) * 1e-6;
  const double b = static_cast<double>(torque.damping_un_m_s_per_rad.value) * 1e-6;
  const double c = static_cast<double>(torque.friction_un_m.value) * 1e-6;
  const double cell = static_cast<double>(torque.orientation_cell_urad.value) * 1e-6;
  const double peak = static_cast<double>(torque.peak_un_m.value) * 1e-6;
  out.push_back(Judged({"torque_damping", "Passivity limit of the torque spring",
                        "K <= 2 b_rot/(T (d + 1)^2)", "N m/rad", "torque/coupling_un_m_per_rad", k,
                        haptics::CouplingStiffness(b, si.tick, si.delay)}));
  out.push_back(Judged({"torque_friction", "Friction that covers one orientation step",
                        "c_rot >= K rho", "N m", "torque/friction_un_m", c, k * cell, true}));
  out.push_back(Judged({"torque_peak", "Peak torque above what one orientation step hides",
                        "peak >= 2 K rho", "N m", "torque/peak_un_m", peak, 2 * k * cell, true}));
}

}  // namespace

std::vector<ProfileCriterion> CheckProfile(const DeviceProfile& profile) {
  Si si(profile);
  double passive = haptics::CouplingStiffness(si.b, si.spring_tick, si.spring_delay);
  std::vector<ProfileCriterion> out = {
      Judged({"coupling_damping", "Passivity limit of the coupling", "Kc <= 2 b/(T (d + 1)^2)",
              "N/m", "coupling_mn_per_mm", si.kc, passive}),
      Judged({"coupling_friction", "Friction that covers the cell of the tip", "c >= Kc S", "N",
              "friction_mn", si.c, si.kc * CellSupportNm(profile) * 1e-9, true}),
      Judged({"coupling_stiffness", "Largest stiffness the device shows", "Kc <= K", "N/m",
              "coupling_mn_per_mm", si.kc, si.k}),
      Judged({"continuous_force", "Continuous force within the peak", "Fcont <= Fpeak", "N",
              "continuous_force_mn", static_cast<double>(profile.continuous_force_mn.value) * 1e-3,
              static_cast<double>(profile.peak_force_mn.value) * 1e-3}),
  };
  if (!profile.structural_mode_hz.source.empty()) {
    out.push_back(Judged({"coupling_mode", "Distance from the first resonance",
                          "Kc <= m (2 pi f1/4)^2", "N/m", "coupling_mn_per_mm", si.kc,
                          static_cast<double>(ModeStiffness_mn_per_mm(profile))}));
  }
  if (profile.torque) AddTorque(*profile.torque, si, out);
  return out;
}

bool IsAcceptable(const std::vector<ProfileCriterion>& criteria) {
  return std::ranges::all_of(criteria, &ProfileCriterion::met);
}

}  // namespace enamel::scene
