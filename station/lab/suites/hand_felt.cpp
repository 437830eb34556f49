#include <algorithm>
#include <atomic>
#include <cmath>

#include "station/lab/suites/hand_cases.h"

namespace enamel::station::lab {
namespace {

constexpr double kEnamel_n_s_per_m = 6500, kCut_m_per_s = 0.43e-3;  // the paper's
constexpr double kHuman_m_per_s = 0.2e-3;                           // mean
constexpr double kGrip_n_per_m = 1000;
// From soft dentin to hard enamel, and mean speeds of strokes: the paper's ranges.
constexpr double kTissues_n_s_per_m[] = {3800, 5200, 6500, 8700, 11'300};
constexpr double kSpeeds_m_per_s[] = {0.2e-3, 0.3e-3, 0.4e-3, 0.48e-3};
constexpr double kRight = fidelity::kShares[1];
constexpr double kOfSeconds = 0.95;  // so many have to be felt right
// Below it the hand rests, and there is nothing to be felt right.
constexpr double kMinFelt_n = 0.02;
constexpr double kDuration_s = 12;

std::vector<HandMotion> AtSpeed(const std::vector<HandMotion>& recorded, double speed, bool quick) {
  std::vector<HandMotion> out;
  for (const HandMotion& r : recorded) out.push_back(ScaledToSpeed(r, speed));
  for (uint64_t seed = 1; recorded.empty() && seed <= (quick ? 2 : 6); ++seed)
    out.push_back(WanderingMotion(speed, kDuration_s, seed));
  return out;
}

void MeasureSeconds(const DeviceModel& m, const std::vector<HandMotion>& motions, SecondsRow* row) {
  for (const HandMotion& motion : motions) {
    fidelity::FeltTrial trial;
    trial.ideal = false;
    trial.b_n_s_per_m = Sym3::Isotropic(row->b_n_s_per_mm * 1e3);
    trial.hand.stiffness_n_per_m = kGrip_n_per_m;
    for (const fidelity::FeltSecond& s : Feel(FeltDeviceOf(m), trial, motion.way_m).seconds) {
      if (s.tool_rms_n < kMinFelt_n) continue;
      ++row->seconds;
      row->within += s.error_rms_n <= kRight * s.tool_rms_n;
    }
  }
}

Table SecondsTable(const std::vector<SecondsRow>& rows, const DeviceModel& m,
                   const std::string& whose) {
  Table t;
  t.title = "Felt: seconds of strokes within 15 % of the ideal tool, %, grip 1 N/mm, " + m.title;
  t.head = {"B N s/mm"};
  for (double v : kSpeeds_m_per_s) t.head.push_back(F(v * 1e3, "%.2f mm/s"));
  int good = 0, cells = 0;
  for (double b : kTissues_n_s_per_m) {
    std::vector<std::string> line = {F(b * 1e-3, "%.1f")};
    for (const SecondsRow& r : rows) {
      if (r.device != m.name || r.b_n_s_per_mm != b * 1e-3) continue;
      ++cells;
      good += r.share() >= kOfSeconds;
      line.push_back(F(100 * r.share(), "%.0f"));
    }
    t.rows.push_back(std::move(line));
  }
  t.note =
      std::to_string(good) + " of " + std::to_string(cells) +
      " cells have 95 % of their seconds within. Of a second: RMS of the error of the force in "
      "the hand, friction, damping and inertia in, over RMS of the tool's force. " +
      whose + " at this mean speed; seconds in which the hand rests are left out.";
  return t;
}

void AddSeconds(SuiteContext& c, const std::vector<HandMotion>& recorded) {
  std::vector<SecondsRow> rows;
  std::vector<const DeviceModel*> devices;
  for (const DeviceModel& m : c.findings.models)
    for (double b : kTissues_n_s_per_m)
      for (double v : kSpeeds_m_per_s) {
        rows.push_back({m.name, b * 1e-3, v * 1e3});
        devices.push_back(&m);
      }
  std::atomic<size_t> done{0};
  ParallelFor(rows.size(), c.options.threads, [&](size_t i) {
    const auto motions = AtSpeed(recorded, rows[i].speed_mm_s * 1e-3, c.options.quick);
    MeasureSeconds(*devices[i], motions, &rows[i]);
    c.progress("felt: seconds", ++done, rows.size());
  });
  const std::string whose = recorded.empty() ? "Generated hands (WanderingMotion)"
                                             : "The recordings in " + c.options.motion;
  for (const DeviceModel& m : c.findings.models)
    c.findings.tables.push_back(SecondsTable(rows, m, whose));
  c.findings.seconds_felt.insert(c.findings.seconds_felt.end(), rows.begin(), rows.end());
}

// The steady cut of the headline, and a hand that works a surface.
std::vector<BudgetRow> BudgetsOf(const DeviceModel& m, const std::vector<HandMotion>& recorded) {
  fidelity::FeltTrial steady;
  // Until the plain spring has settled to a hundredth.
  steady.from_s = 2 + 4.6 * kEnamel_n_s_per_m / m.kc_n_per_m;
  steady.delay_ticks = m.delay_ticks;
  const HandMotion straight =
      ReversalMotion(kCut_m_per_s, steady.from_s + 2, 0, glm::normalize(dvec3(1, 2, 3)));
  fidelity::FeltTrial gives;
  gives.hand.stiffness_n_per_m = kGrip_n_per_m;
  gives.delay_ticks = m.delay_ticks;
  const HandMotion strokes = AtSpeed(recorded, kHuman_m_per_s, true).front();
  std::vector<BudgetRow> out = {
      {m.name, "steady, prescribed", kEnamel_n_s_per_m * 1e-3, kCut_m_per_s * 1e3, {}},
      {m.name, "strokes, 1 N/mm", kEnamel_n_s_per_m * 1e-3, kHuman_m_per_s * 1e3, {}}};
  out[0].budget = BudgetOf(FeltDeviceOf(m), steady, straight.way_m);
  out[1].budget = BudgetOf(FeltDeviceOf(m), gives, strokes.way_m);
  return out;
}

void AddBudgets(SuiteContext& c, const std::vector<HandMotion>& recorded) {
  Table t;
  t.title =
      "Felt: what the error of the force in the hand is made of, N RMS (share of its square, %)";
  t.note =
      "Against an ideal tool in the same hand: B v, no mass, no friction. Each cause is what the "
      "force changes by when the device becomes real in that point, in this order; the changes add "
      "up to the error in every tick, and the shares to 100. A share below 0 takes error away. B "
      "6.5 N s/mm; steady 0.43 mm/s, strokes 0.2 mm/s mean.";
  t.head = {"device", "hand", "tool N", "felt error N", "95 % N"};
  const size_t from = c.findings.budgets.size();
  for (const DeviceModel& m : c.findings.models)
    for (BudgetRow& row : BudgetsOf(m, recorded)) c.findings.budgets.push_back(std::move(row));
  for (size_t i = from; i < c.findings.budgets.size(); ++i) {
    const BudgetRow& r = c.findings.budgets[i];
    const auto model = std::find_if(c.findings.models.begin(), c.findings.models.end(),
                                    [&](const DeviceModel& m) { return m.name == r.device; });
    std::vector<std::string> line = {model->title, r.hand, F(r.budget.tool_rms_n),
                                     F(r.budget.rms_n), F(r.budget.p95_n)};
    for (const fidelity::FeltPart& p : r.budget.parts) {
      if (i == from) t.head.push_back(p.cause);
      line.push_back(F(p.rms_n) + " (" + F(100 * p.share, "%.0f") + ")");
    }
    t.rows.push_back(std::move(line));
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace

void AddFeltInHand(SuiteContext& c, const std::vector<HandMotion>& recorded) {
  AddBudgets(c, recorded);
  AddSeconds(c, recorded);
}

}  // namespace enamel::station::lab
