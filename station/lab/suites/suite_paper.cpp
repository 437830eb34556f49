#include "common/haptics/criteria.h"
#include "station/lab/suites/paper_tables.h"

// Liu et al. 2008, tables 1-3 and the contents of figures 7-9, computed and printed together.
namespace enamel::station::lab {
namespace {

using haptics::EstimatorKind;
using haptics::LawKind;

// Figures 7 to 9 are the Omega's. The paper gives their curves no numbers, so B V is drawn, and what the text states.
struct PaperFigure {
  const char* title;
  double speed_m_per_s, seconds;
  bool difference;  // force less B V, once settled
  struct Level {
    const char* label;
    double force_n;
  };
  std::vector<Level> levels;
};

struct Shown {
  LawKind law;
  EstimatorKind estimator;
  bool pass;
  const char* label;
};
constexpr Shown kShown[] = {
    {haptics::kDefaultLaw, EstimatorKind::kLawsOwn, false, "lead Maxwell (default)"},
    {LawKind::kPaperLimited, EstimatorKind::kLawsOwn, false, "eq. 17, held at dp = 0"},
    {LawKind::kPaperLimited, EstimatorKind::kLawsOwn, true, "eq. 17, passed at dp = 0"},
    {LawKind::kPaperSymmetric, EstimatorKind::kFoawBestFit, false, "eq. 12 on both slopes"}};

std::vector<Sample> Traced(const DeviceModel& m, const PaperFigure& figure, const Shown& s) {
  TrialSpec spec = SpecOf(m, s.law, kEnamel, figure.speed_m_per_s);
  spec.law.estimator.kind = s.estimator;
  spec.law.estimator.window_ticks = 256;
  spec.law.pass_through_at_rest = s.pass;
  spec.settle_s = spec.window_s = figure.difference ? figure.seconds : figure.seconds / 2;
  spec.measure_release = false;
  spec.trace_s = figure.seconds / 300;
  std::vector<Sample> samples = RunTrial(spec).trace;
  if (!figure.difference) return samples;
  std::erase_if(samples, [&](const Sample& q) { return q.t_s < spec.settle_s; });
  for (Sample& q : samples) {
    q.t_s -= spec.settle_s;
    q.force_n -= kEnamel * figure.speed_m_per_s;
  }
  return samples;
}

void AddFigures(const DeviceModel& m, Findings& findings) {
  const PrintedPaper& p = ThePaper();
  const double bound = p.figure8_error_n;
  const PaperFigure figures[] = {
      {"Figure 7, 0.5 mm/s (Omega, enamel): force", 0.5e-3, 3, false, {}},
      {"Figure 7, 0.2 mm/s (Omega, enamel): force", 0.2e-3, 3, false, {}},
      {"Figure 8, 0.4 mm/s (Omega, enamel): force less B V, settled",
       0.4e-3,
       3,
       true,
       {{"paper: +0.1 N", bound}, {"paper: -0.1 N", -bound}}},
      {"Figure 9, 2 mm/s (Omega): largest force",
       2e-3,
       1.5,
       false,
       {{"paper: largest 3.7 N", p.figure9_n}}}};
  for (const PaperFigure& figure : figures) {
    const double target = figure.difference ? 0 : kEnamel * figure.speed_m_per_s;
    for (const Shown& s : kShown) {
      // The others are off by ten and more times the bound (the row of equation 17): its axis would
      // show nothing.
      if (figure.difference && s.law != haptics::kDefaultLaw) continue;
      findings.traces.push_back({figure.title, s.label, target, Traced(m, figure, s)});
    }
    for (const PaperFigure::Level& level : figure.levels) {
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

const PrintedPaper& ThePaper() {
  static const PrintedPaper paper;
  return paper;
}
const PrintedDevice* FindPrinted(const std::string& name) {
  for (const PrintedDevice& p : ThePaper().devices) {
    if (name == p.profile) return &p;
  }
  return nullptr;
}
Table ElementsTable() {
  Table t;
  t.title = "The paper beside ours";
  t.head = {"element", "what it says", "printed", "ours", "verdict", "remark"};
  t.note =
      "docs/paper.md has the same by the paper's own layout; enamel-lab paper says how each was "
      "measured.";
  for (const PaperElement& e : PaperElements(ThePaper()))
    t.rows.push_back({e.element, e.says, e.printed, e.ours, NameOf(e.verdict), e.remark});
  return t;
}
std::vector<Both> PaperDevices(const Findings& f) {
  std::vector<Both> out;
  for (const DeviceModel& m : f.models) {
    if (const PrintedDevice* p = FindPrinted(m.name)) out.push_back({&m, p});
  }
  return out;
}

void RunPaperSuite(SuiteContext& c) {
  c.findings.tables.push_back(ElementsTable());
  c.findings.tables.push_back(DeviceTable(c));
  if (!PaperDevices(c.findings).empty()) c.findings.tables.push_back(MeasuredTable(c));
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
