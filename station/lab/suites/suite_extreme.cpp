#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/haptics/criteria.h"
#include "station/lab/suites/extreme_cases.h"
#include "station/lab/suites/suites.h"

// Stiff and extreme cases, laws driven directly, past profile validation: each cell is cut for a
// few seconds with a light impedance grip and, where the material can hold it, a light force grip.
namespace enamel::station::lab {
namespace {

using haptics::LawKind;

constexpr double kSpeed = 0.43e-3;

Verdict Worse(Verdict a, Verdict b) { return a > b ? a : b; }

std::vector<double> Steps(double lo, double hi, int n) {
  std::vector<double> out;
  for (int i = 0; i < n; ++i)
    out.push_back(lo * std::pow(hi / lo, static_cast<double>(i) / (n - 1)));
  return out;
}

// The tip swings by hundreds of cells, or by a tenth of a millimetre: more than encoder noise.
bool Swings(const TrialSpec& s, const Measurement& m) {
  return m.unstable ||
         (m.deviation_m > std::max(40 * s.plant.resolution_m, 50e-6) && m.ripple_fast_rms_n > 0.05);
}

Verdict OneGrip(TrialSpec s) {
  s.settle_s = 1.5;
  s.window_s = 1;
  s.measure_release = false;
  Measurement m = RunTrial(s);
  // Where the theorem holds, a violated balance is our error, whatever the tip does.
  if (Proved(s)) return m.violation ? Verdict::kUnstable : Verdict::kPassive;
  if (Swings(s, m)) return Verdict::kUnstable;
  if (m.deviation_m > 2.5 * s.plant.resolution_m || m.violation)
    return m.cycle ? Verdict::kBounded : Verdict::kStable;
  return Verdict::kStable;
}

Verdict CellVerdict(TrialSpec s) {
  s.direction = glm::normalize(dvec3(1, 2, 3));
  s.hand_mass_kg = 0.03;
  // The device's own motion is integrated in steps of some 0.12 ms, whatever the loop's rate is.
  s.plant.substeps = std::clamp(static_cast<int>(s.plant.tick_s / 0.12e-3), 1, 80);
  s.hand = HandKind::kImpedance;
  s.hand_stiffness_n_per_m = 1000;
  // A tenth of critical damping: a loose grip, which hides the least.
  s.hand_damping_n_s_per_m = 0.2 * std::sqrt(1000 * (s.hand_mass_kg + s.plant.mass_kg));
  Verdict v = OneGrip(s);
  double b = s.b_n_s_per_m.Trace() / 3;
  // Elsewhere a force hand flies through the material or stops, and gives no information.
  if (v == Verdict::kUnstable || b < 1000 || b > 2e4) return v;
  s.hand = HandKind::kForce;
  s.hand_damping_n_s_per_m = 2;
  return Worse(v, OneGrip(s));
}

VerdictMap MapOf(SuiteContext& c, const char* title, std::vector<double> x, std::vector<double> y,
                 const std::function<TrialSpec(double, double)>& spec) {
  VerdictMap map;
  map.title = title;
  map.x = std::move(x);
  map.y = std::move(y);
  map.cells.resize(map.x.size() * map.y.size());
  std::atomic<size_t> done{0};
  ParallelFor(map.cells.size(), c.options.threads, [&](size_t i) {
    map.cells[i] = CellVerdict(spec(map.x[i % map.x.size()], map.y[i / map.x.size()]));
    c.progress(title, ++done, map.cells.size());
  });
  return map;
}

void AddZWidth(SuiteContext& c, const DeviceModel& m, LawKind law) {
  int n = c.options.quick ? 7 : 15;
  std::string title = "Z-width of " + m.title + ": " + std::string(haptics::FindLaw(law)->name);
  VerdictMap map =
      MapOf(c, title.c_str(), Steps(0.05, 10, n), Steps(1e-3, 1e6, n), [&](double ratio, double b) {
        TrialSpec s = SpecOf(m, law, b * 1e3, kSpeed);
        s.law.kc_n_per_m = ratio * m.max_stiffness_n_per_m;
        return s;
      });
  map.x_label = "Kc / K";
  map.y_label = "B, N s/mm";
  double k = m.max_stiffness_n_per_m, b = m.damping_n_s_per_m;
  double theorem = haptics::CouplingStiffness(b, m.tick_s(), 0) / k,
         friction = 2 * m.friction_n / m.resolution_m / k;
  map.curves.push_back({"theorem: Kc = 2b/T", {{theorem, 1e-3}, {theorem, 1e6}}});
  map.curves.push_back({"friction: Kc = 2c/delta", {{friction, 1e-3}, {friction, 1e6}}});
  VerdictMap::Curve colgate{"Colgate-Schenkel: K beside eq. 1", {}};
  for (double virtual_b : Steps(1e-3, 0.999e-3 * b, 12)) {
    // At B = b nothing is left for stiffness: the curve ends there.
    if (virtual_b > 0.999e-3 * b) break;
    colgate.points.push_back(
        {std::max(0.05, haptics::ColgateSchenkelStiffness(b, virtual_b * 1e3, m.tick_s()) / k),
         virtual_b});
  }
  colgate.points.push_back({0.05, b * 1e-3});
  map.curves.push_back(colgate);
  c.findings.maps.push_back(std::move(map));
}

void AddRateDelay(SuiteContext& c, const DeviceModel& m) {
  VerdictMap map = MapOf(c, ("Loop rate and bus delay on " + m.title + ", Kc kept").c_str(),
                         Steps(100, 20000, c.options.quick ? 6 : 12), {1, 2, 3, 4, 5, 6},
                         [&](double rate, double delay) {
                           DeviceModel at = m;
                           at.rate_hz = rate;
                           at.delay_ticks = static_cast<int>(delay) - 1;
                           return SpecOf(at, haptics::kDefaultLaw, 6500, kSpeed);
                         });
  map.x_label = "loop rate, Hz";
  map.y_label = "1 + ticks of delay";
  VerdictMap::Curve limit{"theorem: Kc = 2b/(T (d + 1)^2)", {}};
  for (double rate : Steps(100, 20000, 40)) {
    // The clause solved for d.
    double d = std::sqrt(2 * m.damping_n_s_per_m * rate / m.kc_n_per_m) - 1;
    if (d >= 0 && d <= 5) limit.points.push_back({rate, 1 + d});
  }
  map.curves.push_back(limit);
  c.findings.maps.push_back(std::move(map));
}

void AddResolutionMass(SuiteContext& c, const DeviceModel& m) {
  int n = c.options.quick ? 5 : 10;
  VerdictMap map =
      MapOf(c, ("Encoder cell and device mass on " + m.title).c_str(), Steps(1e-3, 500, n),
            Steps(1, 2000, n), [&](double delta_um, double mass_g) {
              DeviceModel other = m;
              other.resolution_m = delta_um * 1e-6;
              other.mass_kg = mass_g * 1e-3;
              return SpecOf(other, haptics::kDefaultLaw, 6500, kSpeed);
            });
  map.x_label = "delta, um";
  map.y_label = "mass, g";
  double limit = 2e6 * m.friction_n / m.kc_n_per_m;
  map.curves.push_back({"friction: c = Kc delta / 2", {{limit, 1}, {limit, 2000}}});
  c.findings.maps.push_back(std::move(map));
}

}  // namespace

void RunExtremeSuite(SuiteContext& c) {
  for (const DeviceModel& m : c.findings.models) {
    AddZWidth(c, m, haptics::kDefaultLaw);
    AddZWidth(c, m, LawKind::kPaperLimited);
    AddRateDelay(c, m);
    AddResolutionMass(c, m);
    AddEvents(m, &c.findings.extremes);
  }
  AddVoxelLimits(&c.findings.extremes);
  AddTiming(c);
  AddMargins(c);
  c.findings.tables.push_back(ExtremeTable(c.findings));
}

}  // namespace enamel::station::lab
