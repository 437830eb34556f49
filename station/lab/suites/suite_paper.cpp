#include "common/haptics/criteria.h"
#include "station/lab/suites/paper_tables.h"

// Liu et al. 2008, tables 1-3 and the contents of figures 7-9, computed and printed together.
namespace enamel::station::lab {
namespace {

using haptics::EstimatorKind;
using haptics::LawKind;

// N s/mm and N, as in the paper.
constexpr Printed kPrinted[] = {{"omega3", 0.0051, 0.28, 0.0051, 0.006, 3.7},
                                {"phantom_desktop", 0.0016, 0.13, 0.0022, 0.00175, 0.8},
                                {"bhhd3", 0.003, 0.15, 0.003, 0.0025, 1.1}};

// Figures 7-9 are the Omega's. Their curves are not given as numbers: the values in the text and on
// the axes are drawn as level lines, with the laws in the hand that cuts at the printed speed.
void AddFigures(const DeviceModel& m, Findings& findings) {
  struct Level {
    const char* label;
    double force_n;
  };
  struct Figure {
    const char* title;
    double speed, seconds;
    std::vector<Level> levels;
  };
  const Figure figures[] = {
      {"Figure 7, 0.5 mm/s (Omega, enamel): the limiter's force",
       0.5e-3,
       3,
       {{"paper: close to the real 3.25 N", 3.25}}},
      {"Figure 7, 0.2 mm/s (Omega, enamel): the limiter's force",
       0.2e-3,
       3,
       {{"paper: close to the real 1.3 N", 1.3}}},
      {"Figure 8, 0.4 mm/s (Omega, enamel): measured against computed force",
       0.4e-3,
       3,
       {{"paper: real force + 0.1 N", 2.7}, {"paper: real force - 0.1 N", 2.5}}},
      {"Figure 9, 2 mm/s (Omega): largest force with the damping model",
       2e-3,
       1.5,
       {{"paper: largest 3.7 N", 3.7}}}};
  struct Shown {
    LawKind law;
    EstimatorKind estimator;
    bool pass;
    const char* label;
  };
  const Shown shown[] = {
      {haptics::kDefaultLaw, EstimatorKind::kLawsOwn, false, "lead Maxwell (default)"},
      {LawKind::kPaperLimited, EstimatorKind::kLawsOwn, false, "eq. 17, held at dp = 0"},
      {LawKind::kPaperLimited, EstimatorKind::kLawsOwn, true, "eq. 17, passed at dp = 0"},
      {LawKind::kPaperSymmetric, EstimatorKind::kFoawBestFit, false, "eq. 12 on both slopes"}};
  for (const Figure& figure : figures) {
    double target = kEnamel * figure.speed;
    for (const Shown& s : shown) {
      TrialSpec spec = SpecOf(m, s.law, kEnamel, figure.speed);
      spec.law.estimator.kind = s.estimator;
      spec.law.estimator.window_ticks = 256;
      spec.law.pass_through_at_rest = s.pass;
      spec.settle_s = spec.window_s = figure.seconds / 2;
      spec.measure_release = false;
      spec.trace_s = figure.seconds / 300;
      findings.traces.push_back({figure.title, s.label, target, RunTrial(spec).trace});
    }
    for (const Level& level : figure.levels) {
      // A level is a trace of two points, which the report draws like the others.
      Sample from, to;
      from.force_n = to.force_n = level.force_n;
      to.t_s = figure.seconds;
      findings.traces.push_back({figure.title, level.label, target, {from, to}});
    }
  }
}

Table DeviceTable(SuiteContext& c) {
  Table t;
  t.title = "Device profiles: limits of the literature beside what the renderer uses";
  t.head = {"device",
            "K N/mm",
            "Kc used",
            "2b/T",
            "2c/delta",
            "Colgate-Schenkel K at B = 0",
            "Gil, 1 tick delay",
            "coupling, 1 tick delay",
            "beta = b/(Kc T)",
            "sigma = c/(Kc delta)",
            "cannot render (B = 6.5, 0.43 mm/s)"};
  t.note =
      "The coupling is passive where beta and sigma are at least 1/2. All stiffnesses in N/mm.";
  for (const DeviceModel& m : c.findings.models) {
    double b = m.damping_n_s_per_m, tick = m.tick_s();
    auto groups = haptics::DimensionlessGroups(m.kc_n_per_m, b, m.friction_n, tick, m.resolution_m);
    std::string cannot;
    for (const std::string& s : CannotRender(m, kEnamel, 0.43e-3))
      cannot += (cannot.empty() ? "" : "; ") + s;
    t.rows.push_back(
        {m.title, F(m.max_stiffness_n_per_m * 1e-3, "%.2f"), F(m.kc_n_per_m * 1e-3, "%.2f"),
         F(2e-3 * b / tick, "%.2f"), F(2e-3 * m.friction_n / m.resolution_m, "%.2f"),
         F(haptics::ColgateSchenkelStiffness(b, 0, tick) * 1e-3, "%.2f"),
         F(haptics::GilStiffness(b, 0, tick, 1) * 1e-3, "%.2f"),
         F(haptics::CouplingStiffness(b, tick, 1) * 1e-3, "%.2f"), F(groups.beta, "%.2f"),
         F(groups.sigma, "%.2f"), cannot.empty() ? "nothing" : cannot});
  }
  return t;
}

}  // namespace

const Printed* FindPrinted(const std::string& name) {
  for (const Printed& p : kPrinted) {
    if (name == p.name) return &p;
  }
  return nullptr;
}
std::vector<Both> PaperDevices(const Findings& f) {
  std::vector<Both> out;
  for (const DeviceModel& m : f.models) {
    if (const Printed* p = FindPrinted(m.name)) out.push_back({&m, p});
  }
  return out;
}

void RunPaperSuite(SuiteContext& c) {
  c.findings.tables.push_back(DeviceTable(c));
  if (!PaperDevices(c.findings).empty()) {
    c.findings.tables.push_back(MeasuredTable(c));
    c.findings.tables.push_back(ForetoldTable(c));
  }
  c.findings.tables.push_back(SustainedTable(c));
  std::vector<Both> devices = PaperDevices(c.findings);
  if (!devices.empty()) {
    c.findings.tables.push_back(ArithmeticTable(devices));
    c.findings.tables.push_back(ProportionTable(c, devices));
  }
  for (const auto& [m, p] : devices) {
    if (m->name == "omega3") AddFigures(*m, c.findings);
  }
}

}  // namespace enamel::station::lab
