#include <algorithm>

#include "common/haptics/criteria.h"
#include "station/lab/laws/stability.h"
#include "station/lab/suites/paper_tables.h"

namespace enamel::station::lab {
namespace {

// The device as a plant with its own damping given: the search is only for K and B.
PlantSpec PlantOf(const DeviceModel& m, double damping_n_s_per_m) {
  PlantSpec s;
  s.mass_kg = m.mass_kg;
  s.damping_n_s_per_m = damping_n_s_per_m;
  s.friction_n = m.friction_n;
  s.resolution_m = m.resolution_m;
  s.tick_s = m.tick_s();
  s.substeps = 1;  // the passive search prescribes the motion
  return s;
}

PlantSpec Finely(PlantSpec s) {
  s.substeps = 64;
  return s;
}

PlantSpec Ideal(PlantSpec s) {
  s.friction_n = 0;
  // Practically none, without a division by 0: the ideal device of the closed forms.
  s.resolution_m = 1e-12;
  return Finely(s);
}

constexpr Hold kLightHand{0.05, 500, 4};

// Own damping, swept over the range possible for such devices: independent of K.
constexpr double kDampings[] = {0.5, 2, 8};
}  // namespace

Table MeasuredTable(SuiteContext& c) {
  Table t;
  t.title =
      "Tables 1 and 2, measured: largest K (N/mm) and B of eq. 1 (N s/mm) of the simulated device, "
      "its own damping b given";
  t.head = {"device",
            "b N s/m",
            "K passive",
            "min(2b/T, 2c/delta)",
            "K rests, alone, no c",
            "by its poles",
            "K rests, alone",
            "K rests, light hand",
            "B passive",
            "min(b, cT/delta)",
            "B rests, alone, no c",
            "by its poles",
            "B rests, alone",
            "B rests, light hand",
            "passive B / (K T/2)"};
  t.note =
      "b is swept and does not come from K. Passive: no cyclic motion tried gains energy for ever. "
      "Rests: let go 1 mm away (or jolted by one false reading of 1 mm) the tip swings less and "
      "less; light hand: 0.05 kg, 0.5 N/mm, 4 N s/m. Passive limits follow Colgate-Schenkel and "
      "Abbott-Okamura at every b, so K and B are both proportional to b until friction is the "
      "limit, and B = K T/2 holds whatever b is: eq. 16 says nothing about a device beyond its K. "
      "A spring's limit at rest is the passive one (2b/T) and more in a hand; a damper's at rest "
      "is about 2m/T, forty to a thousand times its passive one here.";
  struct Case {
    const DeviceModel* model;
    double b;
  };
  std::vector<Case> cases;
  for (const DeviceModel& m : c.findings.models) {
    if (FindPrinted(m.name) == nullptr) continue;
    for (double b : kDampings) cases.push_back({&m, b});
  }
  // Filled by index: threads end in any order, the table does not.
  t.rows.resize(cases.size());
  ParallelFor(cases.size(), c.options.threads, [&](size_t i) {
    const DeviceModel& m = *cases[i].model;
    double b = cases[i].b, tick = m.tick_s();
    PlantSpec rough = PlantOf(m, b), fine = Finely(rough), ideal = Ideal(rough);
    // Coarse where the search prescribes the motion, fine where the device moves by itself.
    double k = LargestPassive(rough, Rendered::kSpring),
           damper = LargestPassive(rough, Rendered::kDamper);
    auto Milli = [](double v, const char* format) { return F(v * 1e-3, format); };
    auto Rests = [&](const PlantSpec& s, Rendered what, const Hold& hold) {
      return Milli(LargestStable(s, what, hold), what == Rendered::kSpring ? "%.2f" : "%.3f");
    };
    t.rows[i] = {
        m.title,
        F(b, "%.1f"),
        Milli(k, "%.2f"),
        Milli(haptics::AbbottOkamuraStiffness(b, tick, m.friction_n, m.resolution_m), "%.2f"),
        Rests(ideal, Rendered::kSpring, {}),
        Milli(LinearStableSpring(m.mass_kg, b, tick), "%.2f"),
        Rests(fine, Rendered::kSpring, {}),
        Rests(fine, Rendered::kSpring, kLightHand),
        Milli(damper, "%.5f"),
        Milli(std::min(b, m.friction_n * tick / m.resolution_m), "%.5f"),
        Rests(ideal, Rendered::kDamper, {}),
        Milli(LinearStableDamper(m.mass_kg, b, tick), "%.3f"),
        Rests(fine, Rendered::kDamper, {}),
        Rests(fine, Rendered::kDamper, kLightHand),
        F(damper / (k * tick / 2), "%.3f")};
  });
  return t;
}

}  // namespace enamel::station::lab
