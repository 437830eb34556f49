#include <algorithm>

#include "common/base/file.h"
#include "common/base/in_document.h"
#include "common/scene/delay.h"
#include "common/scene/rate.h"
#include "station/lab/suites/suites.h"

// What stays safe if a calibration is wrong: the largest Kc that the clauses allow at the bad end of each
// measured interval.
namespace enamel::station::lab {
namespace {

using scene::Calibration;
using scene::DeviceProfile;
using scene::Measured;

struct Quantity {
  const char* symbol;
  const char* unit;
  std::optional<Measured> Calibration::*measured;
  scene::Sourced DeviceProfile::*number;
  bool worse_if_larger;
};
constexpr Quantity kQuantities[] = {
    {"b", "mN s/m", &Calibration::damping_mn_s_per_m, &DeviceProfile::damping_mn_s_per_m, false},
    {"c", "mN", &Calibration::friction_mn, &DeviceProfile::friction_mn, false},
    {"m", "g", &Calibration::mass_g, &DeviceProfile::mass_g, false},
    {"delta", "nm", &Calibration::resolution_nm, &DeviceProfile::resolution_nm, true},
    {"delay", "ticks", &Calibration::bus_delay_ticks, &DeviceProfile::bus_delay_ticks, true},
    {"f1", "Hz", &Calibration::structural_mode_hz, &DeviceProfile::structural_mode_hz, false},
};

int64_t BadEndOf(const Quantity& q, const Measured& m) {
  return q.worse_if_larger ? m.value + m.uncertainty
                           : std::max<int64_t>(m.value - m.uncertainty, 0);
}

void Set(const Quantity& q, int64_t value, DeviceProfile* profile) {
  profile->*q.number = {value, "calibration"};
}

scene::LargestCoupling LargestOf(const DeviceProfile& profile, int64_t rate_hz) {
  return scene::LargestCouplingAt(
      profile, rate_hz,
      std::clamp<int64_t>(profile.bus_delay_ticks.value, 0, scene::kMaxDelay_ticks));
}

std::vector<std::string> Line(const std::string& what, const std::string& interval,
                              const std::string& bad, const scene::LargestCoupling& largest,
                              int64_t kc) {
  return {what,
          interval,
          bad,
          F(static_cast<double>(largest.coupling_mn_per_mm) * 1e-3, "%.2f"),
          scene::CouplingLimitName(largest.limit),
          kc <= largest.coupling_mn_per_mm ? "safe" : "NOT SAFE"};
}

}  // namespace

Result<Calibration> CalibrationIn(const std::string& path) {
  constexpr size_t kLargest = 1 << 20;
  ENAMEL_ASSIGN_OR_RETURN(Bytes bytes, ReadFile(path, kLargest));
  Result<Calibration> calibration =
      scene::CalibrationFromJson({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!calibration.ok()) return InDocument(path, calibration.status());
  return calibration;
}

Table BadEnds(const DeviceProfile& profile, const Calibration& calibration) {
  Table t;
  t.title = "What stays safe if the calibration is wrong: " + profile.title;
  const int64_t kc = profile.coupling_mn_per_mm.value;
  t.note =
      "The largest Kc that damping, friction, structure and first resonance allow with one "
      "quantity at the "
      "bad end of its 95 % interval and the others as measured. The profile's Kc is " +
      F(static_cast<double>(kc) * 1e-3, "%.2f") + " N/mm.";
  t.head = {"quantity", "measured", "bad end", "Kc N/mm", "limit", "profile's Kc"};
  DeviceProfile measured = profile;
  for (const Quantity& q : kQuantities) {
    if (const auto& m = calibration.*q.measured) Set(q, m->value, &measured);
  }
  const int64_t rate = calibration.rate_hz;
  t.rows.push_back(Line("as measured", "", "", LargestOf(measured, rate), kc));
  DeviceProfile all = measured;
  for (const Quantity& q : kQuantities) {
    const auto& m = calibration.*q.measured;
    if (!m) continue;
    DeviceProfile one = measured;
    Set(q, BadEndOf(q, *m), &one);
    Set(q, BadEndOf(q, *m), &all);
    t.rows.push_back(Line(
        q.symbol, std::to_string(m->value) + " ± " + std::to_string(m->uncertainty) + " " + q.unit,
        std::to_string(BadEndOf(q, *m)), LargestOf(one, rate), kc));
  }
  t.rows.push_back(Line("all at once", "", "", LargestOf(all, rate), kc));
  return t;
}

void RunCalibrationSuite(SuiteContext& c) {
  if (c.options.calibration.empty()) return;
  const Result<Calibration> calibration = CalibrationIn(c.options.calibration);
  for (const DeviceModel& m : c.findings.models) {
    if (calibration.ok() && m.name == calibration->profile)
      c.findings.tables.push_back(BadEnds(m.profile, *calibration));
  }
}

}  // namespace enamel::station::lab
