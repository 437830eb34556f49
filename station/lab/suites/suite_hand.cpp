#include <algorithm>
#include <atomic>
#include <cmath>

#include "station/lab/laws/withdrawal.h"
#include "station/lab/suites/hand_cases.h"
#include "station/lab/suites/suites.h"

// The law in hands that give: felt error against an ideal damper in the same hand, on the positions that
// real encoders and drivers give, and what may not happen to a hand.
namespace enamel::station::lab {
namespace {

constexpr double kStroke_m_per_s = 0.43e-3;  // of the paper's cuts
constexpr double kHuman_m_per_s = 0.2e-3;    // mean; a recording's peaks are five times that
const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

// Generated hands: the seeds of WanderingMotion that the felt figures are means over.
constexpr uint64_t kHands = 3;
constexpr const char* kGenerated = "wandering-";

std::vector<HandMotion> Motions(const std::vector<HandMotion>& recorded, bool quick) {
  std::vector<HandMotion> all;
  // People at different paces are compared at one mean speed, with their own shape.
  for (const HandMotion& r : recorded) all.push_back(ScaledToSpeed(r, kHuman_m_per_s));
  auto Add = [&](HandMotion motion, const std::string& name) {
    motion.name = name;
    all.push_back(std::move(motion));
  };
  for (uint64_t seed = 1; seed <= (recorded.empty() ? kHands : 1); ++seed)
    Add(WanderingMotion(kHuman_m_per_s, 12, seed), kGenerated + std::to_string(seed));
  Add(StrokesMotion(kStroke_m_per_s, 2, 4, kOblique), "strokes-2s");
  if (quick) return all;
  Add(StrokesMotion(kStroke_m_per_s, 1, 8, kOblique), "strokes-1s");
  Add(StrokesMotion(kStroke_m_per_s, 0.5, 16, kOblique), "strokes-0.5s");
  Add(ReversalMotion(kStroke_m_per_s, 6, 4, kOblique), "reversal");
  Add(CircleMotion(kStroke_m_per_s, 0.5e-3), "circle");
  return all;
}

bool SameGrip(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool Recorded(const HandRow& r) { return r.motion.starts_with("human-"); }

// The felt figures are means over the recordings where a folder of them was named, else over the generated
// hands.
bool Counts(const std::vector<HandRow>& rows, const HandRow& r) {
  return std::any_of(rows.begin(), rows.end(), Recorded) ? Recorded(r)
                                                         : r.motion.starts_with(kGenerated);
}

// Mean over the motions that count, in percent, "law (plain spring)"; a star where a motion of any kind is
// felt worse than with the plain spring by more than a point.
std::string FeltText(const std::vector<HandRow>& rows, const std::string& device, double b,
                     double rate_hz, double grip) {
  double law = 0, plain = 0;
  int n = 0;
  bool worse = false;
  for (const HandRow& r : rows) {
    if (r.device != device || r.b_n_s_per_mm != b || r.rate_hz != rate_hz ||
        r.lattice != "cartesian" || r.delay_ticks != 0 || !SameGrip(r.hand_n_per_mm, grip) ||
        std::isnan(r.felt_error) || r.motion == "steady")
      continue;
    worse |= r.felt_error > r.maxwell_error + 0.01;
    if (!Counts(rows, r)) continue;
    law += r.felt_error;
    plain += r.maxwell_error;
    ++n;
  }
  if (n == 0) return "";
  return F(100 * law / n, "%.0f") + " (" + F(100 * plain / n, "%.0f") + ")" + (worse ? " *" : "");
}

void AddFeltTable(SuiteContext& c, const std::vector<HandRow>& rows) {
  Table t;
  t.title = "Error of the force sent in hands that give, %: default law (plain Maxwell)";
  t.note =
      "RMS of the force sent less that of an ideal damper in the same hand on the same device, "
      "over the latter's. Mean over " +
      (c.options.motion.empty() ? std::to_string(kHands) + " generated hands (WanderingMotion)"
                                : "the recordings in " + c.options.motion) +
      ", all at 0.2 mm/s mean. Cells "
      "along the axes, no delay. *: a motion of any kind is felt worse than with plain Maxwell by "
      "more than a point (rows in --json)";
  t.head = {"device", "B N s/mm", "rate Hz", "Kc N/mm", "0.3 N/mm",
            "1 N/mm", "2 N/mm",   "5 N/mm",  "20 N/mm", "prescribed"};
  for (const DeviceModel& m : c.findings.models) {
    struct Line {
      double b, rate_hz, kc;
    };
    std::vector<Line> lines;
    for (const HandRow& r : rows) {
      if (r.device != m.name || std::isnan(r.felt_error) || r.lattice != "cartesian" ||
          r.delay_ticks != 0 || r.motion == "steady")
        continue;
      if (std::none_of(lines.begin(), lines.end(), [&](const Line& l) {
            return l.b == r.b_n_s_per_mm && l.rate_hz == r.rate_hz;
          }))
        lines.push_back({r.b_n_s_per_mm, r.rate_hz, r.kc_n_per_mm});
    }
    for (const Line& l : lines) {
      std::vector<std::string> row = {m.title, F(l.b, "%.1f"), F(l.rate_hz, "%.0f"),
                                      F(l.kc, "%.2f")};
      for (double grip : {0.3, 1.0, 2.0, 5.0, 20.0, kNotApplicable})
        row.push_back(FeltText(rows, m.name, l.b, l.rate_hz, grip));
      t.rows.push_back(std::move(row));
    }
  }
  c.findings.tables.push_back(std::move(t));
}

// The largest of a figure over the rows that have it, and how many are beyond a bound of their own.
struct Worst {
  double value = kNotApplicable;
  int beyond = 0, of = 0;
  void Add(double v, double bound) {
    if (std::isnan(v)) return;
    value = of == 0 ? v : std::max(value, v);
    ++of;
    beyond += v > bound + 1e-9;
  }
  std::string Text(const char* format, double factor = 1) const {
    if (of == 0) return "";
    std::string text = F(value * factor, format);
    if (beyond > 0) text += " (" + std::to_string(beyond) + " of " + std::to_string(of) + ") *";
    return text;
  }
};

void AddBoundsTable(SuiteContext& c, const std::vector<HandRow>& rows) {
  Table t;
  t.title =
      "What may not happen to a hand: the worst case, and how many are beyond their bound (*)";
  t.note =
      "Steady cut on 24 lattices rounded again: RMS off B v at most 0.1 N, with a count of noise "
      "max(0.1 N, 1.8 Kc delta); least force at least 90 %. Lifts: pull at most 0.15 N; thrown "
      "back "
      "at most 3 of 72. Hands that push: peak to peak at most plain Maxwell's + max(0.06 N, 0.6 Kc "
      "delta). First stroke after air at 50 mm/s: at most 0.15 N beyond B v. Way to 0.1 N at 2, "
      "10, "
      "50 mm/s: at most plain Maxwell's and a cell. Withdrawals with the core: 0.15 N. Ripple "
      "above "
      "15 Hz in felt rows: 0.25 Kc delta + 0.02 N, or plain Maxwell's. Energy: of every proved row";
  t.head = {"device",           "steady rounded N", "least force %", "steady, count N",
            "lift pull N",      "thrown back",      "push swing N",  "first stroke N",
            "way beyond um",    "behind in air um", "withdrawal N",  "ripple N",
            "energy below 0, J"};
  for (const DeviceModel& m : c.findings.models) {
    const double count_n = m.kc_n_per_m * m.resolution_m;
    Worst rounded, least, noisy, lift, push, first, way, behind, withdrawal, ripple, energy;
    int thrown = 0, lifts = 0;
    for (const HandRow& r : rows) {
      if (r.device != m.name) continue;
      const bool noise = r.lattice.ends_with("-count");
      if (r.motion == "steady") {
        (noise ? noisy : rounded).Add(r.off_rms_n, noise ? std::max(0.1, 1.8 * count_n) : 0.1);
        if (!noise) least.Add(-r.least_share, -0.9);
      } else if (r.motion.starts_with("lift")) {
        lift.Add(r.pull_n, 0.15);
        thrown += r.cycles;
        ++lifts;
      } else if (r.motion.starts_with("withdraw")) {
        withdrawal.Add(r.pull_n, 0.15);
      } else if (r.lattice == "cartesian" && r.delay_ticks == 0 && r.rate_hz == m.rate_hz) {
        ripple.Add(r.felt_error >= 0 ? r.ripple_n : kNotApplicable,
                   std::max(0.25 * count_n + 0.02, r.maxwell_ripple_n));
      }
      push.Add(r.swing_n - r.maxwell_swing_n, std::max(0.06, 0.6 * count_n));
      first.Add(r.excess_n, 0.15);
      way.Add(r.way_m - r.maxwell_way_m, m.resolution_m);
      behind.Add(r.behind_m, 1e-9);
      if (r.proved) energy.Add(-r.energy_min_j, 1e-12);
    }
    t.rows.push_back(
        {m.title, rounded.Text("%.3f"), least.Text("%.0f", -100), noisy.Text("%.3f"),
         lift.Text("%.3f"),
         std::to_string(thrown) + " of " + std::to_string(lifts) + (thrown > 3 ? " *" : ""),
         push.Text("%.3f"), first.Text("%.3f"), way.Text("%.0f", 1e6), behind.Text("%.2f", 1e6),
         withdrawal.Text("%.3f"), ripple.Text("%.3f"), energy.Text("%.1e")});
  }
  c.findings.tables.push_back(std::move(t));
}

// For the fronts against run time: the anchored laws in a hand of 1 N/mm, and pulled out.
void AddFrontRows(SuiteContext& c, const DeviceModel& m, const cutting::Volume& block) {
  for (haptics::LawKind law : {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell}) {
    fidelity::FeltTrial trial;
    trial.law = law;
    trial.hand.stiffness_n_per_m = 1000;
    trial.ideal = false;
    const fidelity::FeltFigures f =
        Feel(FeltDeviceOf(m), trial, WanderingMotion(kHuman_m_per_s, 12, 1).way_m);
    double pull = 0;
    for (const NamedBur& bur : WithdrawalBurs()) {
      Withdrawal w{bur.bur, Cut::kSideMill, 0.05, false, law};
      w.kc_n_per_m = m.kc_n_per_m;
      w.cell_m = m.resolution_m;
      w.peak_force_n = m.peak_force_n;
      pull = std::max(pull, RunWithdrawal(w, block).opposing_n);
    }
    TrialSpec spec = SpecOf(m, law, 6500, kStroke_m_per_s);
    Row row = RunRow(m, spec);
    row.suite = "hand-front";
    row.title = "wandering hand of 1 N/mm, side-milling burs pulled back at 50 mm/s";
    row.ns_per_tick = NanosecondsPerTick(spec);
    row.extra = {{"felt_error", f.felt_error()}, {"pull_n", pull}};
    c.findings.rows.push_back(std::move(row));
  }
}

HandCases CasesFor(const DeviceModel& m, const std::vector<HandMotion>& recorded,
                   const cutting::Volume& block, bool quick) {
  HandCases cases;
  const std::vector<HandMotion> motions = Motions(recorded, quick);
  const std::vector<HandMotion> few = Motions(recorded, true);
  AddFeltCases(m, motions, {6500, 1000, 300}, &cases);
  if (!quick) {
    // Spring and law four times as often; and the spring eight times as often, by the board's firmware.
    // Each with the Kc of its own clause.
    AddFeltCases(AtRate(m, 4000, true), few, {6500}, &cases);
    AddFeltCases(OnBoard(m, 8000), few, {6500}, &cases);
  }
  AddReadingCases(m, few, &cases);
  AddSteadyCases(m, &cases);
  AddPushCases(m, &cases);
  AddLoadPushCases(m, &cases);
  AddLiftCases(m, &cases);
  AddApproachCases(m, &cases);
  AddWithdrawalCases(m, block, quick, &cases);
  return cases;
}

}  // namespace

void RunHandSuite(SuiteContext& c) {
  std::vector<HandMotion> recorded;
  if (!c.options.motion.empty()) {
    // RunQualify has refused a path that holds none.
    Result<std::vector<HandMotion>> found = RecordedMotions(c.options.motion);
    ENAMEL_CHECK(found.ok());
    recorded = std::move(*found);
  }
  const cutting::Volume block = WithdrawalBlock();
  const size_t from = c.findings.hands.size();
  for (const DeviceModel& m : c.findings.models) {
    HandCases cases = CasesFor(m, recorded, block, c.options.quick);
    std::atomic<size_t> done{0};
    ParallelFor(cases.size(), c.options.threads, [&](size_t i) {
      cases[i].run(cases[i].row);
      c.progress(("hand: " + m.name).c_str(), ++done, cases.size());
    });
    for (HandCase& one : cases) c.findings.hands.push_back(std::move(one.row));
    AddFrontRows(c, m, block);
  }
  const std::vector<HandRow> rows(c.findings.hands.begin() + static_cast<long>(from),
                                  c.findings.hands.end());
  AddFeltTable(c, rows);
  AddBoundsTable(c, rows);
  AddFeltInHand(c, recorded);
}

}  // namespace enamel::station::lab
