#include "station/lab/laws/model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/haptics/criteria.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/delay.h"
#include "common/scene/json/json.h"
#include "common/scene/own_friction.h"

namespace enamel::station::lab {
namespace {

using scene::DeviceProfile;

std::string Text(const char* format, double a, double b = 0, double c = 0) {
  char out[300];
  std::snprintf(out, sizeof out, format, a, b, c);
  return out;
}

Status Refuse(const char* field, const std::string& what) {
  return {Code::kInvalidInput, what, field};
}

}  // namespace

double DeviceModel::PassiveKc(double rate) const {
  return std::min(haptics::CouplingStiffness(damping_n_s_per_m, 1 / rate, delay_ticks),
                  2 * friction_n / resolution_m);
}

std::vector<DeviceProfile> ShippedProfiles() {
  std::vector<DeviceProfile> all = scene::BuiltinProfiles();
  std::erase_if(all, [](const DeviceProfile& p) { return !scene::HasMotors(p); });
  return all;
}

Result<Unit> UnitOf(const DeviceProfile& shipped, bool calibrated) {
  const int64_t rate_hz = shipped.rate_hz.value;
  const int64_t ticks = calibrated ? shipped.bus_delay_ticks.value
                                   : scene::DelayOfAttached(shipped, nullptr, rate_hz).ticks;
  const int64_t c_mn = shipped.friction_mn.value;
  const int64_t told_mn = calibrated ? c_mn * (100 - scene::kMaxUncertainty_percent) / 100 : c_mn;
  const auto unit = calibrated ? scene::WithFriction(shipped, told_mn) : shipped;
  ENAMEL_ASSIGN_OR_RETURN(const auto profile, scene::WithDelay(unit, rate_hz, ticks));
  ENAMEL_ASSIGN_OR_RETURN(auto model, ModelOf(profile));
  Unit out{std::move(model), calibrated, {}};
  out.model.friction_n = static_cast<double>(c_mn) * 1e-3;
  out.told = {dvec3(static_cast<double>(told_mn) * 1e-3), calibrated};
  return out;
}

std::vector<Unit> UnitsOf(const std::vector<DeviceModel>& models) {
  std::vector<Unit> out;
  for (const DeviceModel& m : models) {
    for (const bool calibrated : {true, false}) {
      Result<Unit> unit = UnitOf(m.profile, calibrated);
      if (unit.ok()) out.push_back(std::move(*unit));
    }
  }
  return out;
}

Result<DeviceModel> ModelOf(const DeviceProfile& p) {
  if (p.max_stiffness_mn_per_mm.value <= 0)
    return Refuse("max_stiffness_mn_per_mm", "expected a stiffness above 0 mN/mm");
  if (p.coupling_mn_per_mm.value <= 0)
    return Refuse("coupling_mn_per_mm", "expected a coupling stiffness above 0 mN/mm");
  if (p.resolution_nm.value <= 0)
    return Refuse("resolution_nm", "expected an encoder cell above 0 nm");
  if (p.rate_hz.value <= 0) return Refuse("rate_hz", "expected a loop rate above 0 Hz");
  if (p.mass_g.value <= 0) return Refuse("mass_g", "expected a mass above 0 g");
  if (p.damping_mn_s_per_m.value < 0)
    return Refuse("damping_mn_s_per_m", "expected damping of 0 or more");
  if (p.friction_mn.value < 0) return Refuse("friction_mn", "expected friction of 0 or more");
  if (p.peak_force_mn.value <= 0)
    return Refuse("peak_force_mn", "expected a peak force above 0 mN");
  if (p.bus_delay_ticks.value < 0) return Refuse("bus_delay_ticks", "expected 0 ticks or more");
  if (p.board_spring) {
    return Refuse("board_spring",
                  "the laws are compared with the spring on the station: leave it out, or read the "
                  "rows 'on_board' of 'enamel-lab qualify --suite hand'");
  }
  DeviceModel m;
  m.profile = p;
  m.name = p.name;
  m.title = p.title;
  m.resolution_m = static_cast<double>(p.resolution_nm.value) * 1e-9;
  m.max_stiffness_n_per_m = static_cast<double>(p.max_stiffness_mn_per_mm.value);
  m.kc_n_per_m = static_cast<double>(p.coupling_mn_per_mm.value);
  m.damping_n_s_per_m = static_cast<double>(p.viscous_mn_s_per_m()) * 1e-3;
  m.friction_n = static_cast<double>(p.friction_mn.value) * 1e-3;
  m.mass_kg = static_cast<double>(p.mass_g.value) * 1e-3;
  m.peak_force_n = static_cast<double>(p.peak_force_mn.value) * 1e-3;
  m.continuous_force_n = static_cast<double>(p.continuous_force_mn.value) * 1e-3;
  m.rate_hz = static_cast<double>(p.rate_hz.value);
  m.delay_ticks = static_cast<int>(p.bus_delay_ticks.value);
  m.mode_hz = static_cast<double>(p.structural_mode_hz.value);
  m.thermal_s = static_cast<double>(p.thermal_time_constant_ms.value) * 1e-3;
  m.provenance = {{"delta", p.resolution_nm.source},
                  {"K", p.max_stiffness_mn_per_mm.source},
                  {"Kc", p.coupling_mn_per_mm.source},
                  {"b", p.damping_mn_s_per_m.source},
                  {"c", p.friction_mn.source},
                  {"mass", p.mass_g.source},
                  {"peak force", p.peak_force_mn.source},
                  {"continuous force", p.continuous_force_mn.source},
                  {"rate", p.rate_hz.source},
                  {"delay", p.bus_delay_ticks.source}};
  for (const auto& [what, number] :
       {std::pair{"structural mode", &p.structural_mode_hz},
        std::pair{"thermal time constant", &p.thermal_time_constant_ms}}) {
    m.provenance.push_back({what, number->source.empty() ? "not known" : number->source});
  }
  double allowed = m.PassiveKc(m.rate_hz);
  // Refused here: otherwise every suite would measure the vibration of an impossible device.
  if (m.kc_n_per_m > allowed * (1 + 1e-9)) {
    return Refuse("coupling_mn_per_mm", Text("Kc %.0f mN/mm is above what is passive at %.0f Hz "
                                             "with this b, c and delay: lower it to %.0f mN/mm",
                                             m.kc_n_per_m, m.rate_hz, std::floor(allowed)));
  }
  return m;
}

DeviceModel AtRate(const DeviceModel& model, double rate_hz, bool scale_kc) {
  DeviceModel m = model;
  m.rate_hz = rate_hz;
  // The same share of the limit at another rate, so that rates are compared at equal caution.
  double share = model.kc_n_per_m / haptics::CouplingStiffness(model.damping_n_s_per_m,
                                                               model.tick_s(), model.delay_ticks);
  double limit = haptics::CouplingStiffness(m.damping_n_s_per_m, m.tick_s(), m.delay_ticks);
  if (scale_kc || m.kc_n_per_m > limit)
    m.kc_n_per_m = std::min(share * limit, 2 * m.friction_n / m.resolution_m);
  return m;
}

DeviceModel OnBoard(const DeviceModel& model, double spring_hz) {
  DeviceModel m = model;
  m.board = {static_cast<int>(spring_hz / model.rate_hz + 0.5), 1, 1};
  m.kc_n_per_m = ClauseKc(m, haptics::CartesianCell(dvec3(m.resolution_m)), 0);
  return m;
}

double ClauseKc(const DeviceModel& m, const haptics::TipCell& cell, int delay_ticks) {
  const dvec3 per_kc = cell.Friction(1);
  const double most = std::max({per_kc.x, per_kc.y, per_kc.z});
  return std::min(haptics::CouplingStiffness(m.damping_n_s_per_m, 1 / m.spring_hz(),
                                             m.SpringDelay(delay_ticks)),
                  m.friction_n / most);
}

fidelity::FeltDevice FeltDeviceOf(const DeviceModel& m) {
  return {m.mass_kg,    m.damping_n_s_per_m, m.friction_n, m.resolution_m,
          m.kc_n_per_m, m.peak_force_n,      m.tick_s(),   m.board};
}

std::vector<std::string> CannotRender(const DeviceModel& m, double b, double speed) {
  std::vector<std::string> out;
  double force = b * speed, tau = b / m.kc_n_per_m;
  if (force > m.peak_force_n) {
    out.push_back(Text("B V = %.2f N is above the peak force of %.2f N: the bur would run away",
                       force, m.peak_force_n));
  } else if (force > m.continuous_force_n) {
    // First-order motor heating: from cold, (F/Fc)^2 (1 - exp(-t/tau)) reaches 1 at t.
    double r = m.continuous_force_n / force;
    double constants = -std::log(1 - r * r);
    std::string limit =
        Text("B V = %.2f N is above the continuous force of %.2f N: from cold it may last ", force,
             m.continuous_force_n);
    out.push_back(limit + (m.thermal_s > 0 ? Text("%.1f s", constants * m.thermal_s)
                                           : Text("%.2f thermal time constants", constants)));
  }
  if (tau > 3)
    out.push_back(
        Text("B/Kc = %.1f s is above 3 s: the force takes longer than a stroke to build up", tau));
  return out;
}

TrialSpec SpecOf(const DeviceModel& m, haptics::LawKind law, double b, double speed) {
  TrialSpec s;
  s.plant.mass_kg = m.mass_kg;
  s.plant.damping_n_s_per_m = m.damping_n_s_per_m;
  s.plant.friction_n = m.friction_n;
  s.plant.resolution_m = m.resolution_m;
  s.plant.tick_s = m.tick_s();
  s.plant.delay_ticks = m.delay_ticks;
  s.plant.mode_hz = m.mode_hz;
  // 0.17 ms a step at 1 kHz; IntegrationError gives its error.
  s.plant.substeps = m.rate_hz > 2500 ? 2 : m.rate_hz > 1500 ? 4 : 6;
  s.law.kind = law;
  s.law.kc_n_per_m = m.kc_n_per_m;
  s.law.resolution_m = dvec3(m.resolution_m);
  s.law.tick_s = m.tick_s();
  s.peak_force_n = m.peak_force_n;
  s.b_n_s_per_m = Sym3::Isotropic(b);
  s.speed_m_per_s = speed;
  return s;
}

}  // namespace enamel::station::lab
