#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "station/lab/suites/front.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::EstimatorKind;
using haptics::LawKind;

constexpr double kSpeed = 0.43e-3;
constexpr double kEnamel = 6500;

struct Grid {
  std::vector<double> rates_hz, materials;
  std::vector<EstimatorKind> estimators;
};

Grid GridFor(bool quick) {
  // One rate, one tissue, and one estimator of each kind: a difference and a window.
  if (quick)
    return {{1000}, {6500}, {EstimatorKind::kBackwardDifference, EstimatorKind::kFoawBestFit}};
  Grid g{{500, 1000, 2000, 4000, 8000}, {500, 2500, 5200, 6500, 8700, 11300}, {}};
  for (const auto& e : haptics::VelocityEstimators()) g.estimators.push_back(e.kind);
  return g;
}

// The other laws use no speed, or their own.
bool UsesEstimator(LawKind law) {
  return law != LawKind::kMaxwell && law != LawKind::kLeadMaxwell &&
         law != LawKind::kVirtualCoupling;
}

struct Grip {
  HandKind kind;
  double stiffness;
};
constexpr Grip kGrips[] = {{HandKind::kVelocity, 0},
                           {HandKind::kForce, 0},
                           {HandKind::kImpedance, 1000},
                           {HandKind::kImpedance, 200}};

struct Job {
  const DeviceModel* model;
  TrialSpec spec;
};

// Cuts are oblique: an axis cut hides the slow axes.
const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

void AddJobs(const DeviceModel& at_rate, const Grid& grid, std::vector<Job>* jobs) {
  for (const auto& law : haptics::ForceLaws()) {
    std::vector<EstimatorKind> estimators = {EstimatorKind::kLawsOwn};
    if (UsesEstimator(law.kind)) estimators = grid.estimators;
    for (EstimatorKind estimator : estimators) {
      for (double b : grid.materials) {
        for (const Grip& grip : kGrips) {
          TrialSpec s = SpecOf(at_rate, law.kind, b, kSpeed);
          s.law.estimator.kind = estimator;
          // 0.128 s, but never more samples than the limit of the adaptive windows.
          s.law.estimator.window_ticks = std::min(256, static_cast<int>(0.128 * at_rate.rate_hz));
          s.direction = kOblique;
          s.hand = grip.kind;
          s.hand_stiffness_n_per_m = grip.stiffness;
          s.hand_damping_n_s_per_m =
              grip.kind == HandKind::kForce
                  ? 2
                  // 0.3 of critical damping: 2 * 0.3 sqrt(k m).
                  : 0.6 * std::sqrt(grip.stiffness * (s.hand_mass_kg + at_rate.mass_kg));
          jobs->push_back({&at_rate, s});
        }
      }
    }
  }
}

std::string CostKey(const Row& r) {
  return r.law + "/" + r.estimator + "/" + std::to_string(r.rate_hz);
}

// A row's `pareto`: its law is undominated in time and every metric of front.h.
void MarkPareto(const std::vector<DeviceModel>& models, std::vector<Row>& rows, size_t from) {
  for (const DeviceModel& m : models) {
    std::map<std::string, bool> undominated;
    for (const LawPoint& p : LawPointsOf(rows, m.name)) undominated[p.name] = p.undominated;
    for (size_t i = from; i < rows.size(); ++i) {
      Row& r = rows[i];
      if (r.profile != m.name || std::fabs(r.b_n_s_per_mm - 6.5) > 1e-9) continue;
      auto found = undominated.find(LawPointName(r));
      r.pareto = found != undominated.end() && found->second;
    }
  }
}

void AddTraces(const DeviceModel& model, Findings& findings) {
  struct Shown {
    LawKind law;
    EstimatorKind estimator;
    const char* label;
  };
  // One of each kind, drawn into one frame: the default, the plain spring, and the paper's.
  for (Shown shown :
       {Shown{LawKind::kLeadMaxwell, EstimatorKind::kLawsOwn, "lead Maxwell (default)"},
        Shown{LawKind::kMaxwell, EstimatorKind::kLawsOwn, "Maxwell"},
        Shown{LawKind::kPaperSymmetric, EstimatorKind::kFoawBestFit, "eq. 12 both slopes"},
        Shown{LawKind::kPaperLimited, EstimatorKind::kBackwardDifference, "eq. 17 as printed"}}) {
    TrialSpec s = SpecOf(model, shown.law, kEnamel, kSpeed);
    s.law.estimator.kind = shown.estimator;
    s.law.estimator.window_ticks = 256;
    s.direction = kOblique;
    // 4.5 tau: the plain coupling is within 1 % of its force then.
    s.settle_s = 4.5 * kEnamel / model.kc_n_per_m;
    s.trace_s = s.settle_s / 400;
    Measurement m = RunTrial(s);
    findings.traces.push_back({model.title + ": velocity hand, 0.43 mm/s, enamel, starts and stops",
                               shown.label, m.target_n, m.trace});
  }
}

// The table of goals: B = 6.5 at 0.43 mm/s, worst of axis and oblique cuts.
void AddGoalTable(SuiteContext& c) {
  Table t;
  t.title = "Figures of the default law: B = 6.5 N s/mm, 0.43 mm/s (2.795 N), 1 kHz";
  t.head = {"device",       "goal per axis N",   "velocity hand N",    "felt RMS N",
            "felt 95 % N",  "rise / floor",      "release B/Kc",       "ripple N",
            "kick N",       "force hand N",      "imp. 1 N/mm",        "imp. 0.2 N/mm",
            "felt, give N", "deviation / delta", "energy above floor", "ns / tick"};
  t.note =
      "Worst of five directions; force and impedance hands of 0.02, 0.1 and 0.5 kg, the force hand "
      "with 0 and 2 N s/m of its own. "
      "The force hand's error is |B V_anchor - R|. Felt: force in the hand, with the device's "
      "friction, damping "
      "and inertia, off B V of the tip, as a vector; of the velocity hand, and RMS of the hands "
      "that give.";
  const dvec3 ways[] = {dvec3(1, 0, 0), glm::normalize(dvec3(1, 1, 0)), kOblique,
                        glm::normalize(dvec3(1, 0.1, 0.05)), glm::normalize(dvec3(1, -0.4, 0.02))};
  for (const DeviceModel& m : c.findings.models) {
    // A device that cannot give 2.8 N at all has no figure here.
    if (kEnamel * kSpeed > m.peak_force_n) continue;
    std::vector<Job> jobs;
    for (const dvec3& way : ways) {
      for (const Grip& grip : kGrips) {
        for (double mass : {0.02, 0.1, 0.5}) {
          for (double damping : {0.0, 2.0}) {
            bool velocity = grip.kind == HandKind::kVelocity, force = grip.kind == HandKind::kForce;
            if ((velocity && mass > 0.02) || (!force && damping > 0)) continue;
            TrialSpec s = SpecOf(m, haptics::kDefaultLaw, kEnamel, kSpeed);
            s.direction = way;
            s.hand = grip.kind;
            s.hand_mass_kg = mass;
            s.hand_stiffness_n_per_m = grip.stiffness;
            s.hand_damping_n_s_per_m =
                force ? damping : 0.6 * std::sqrt(grip.stiffness * (mass + m.mass_kg));
            jobs.push_back({&m, s});
          }
        }
      }
    }
    std::vector<Row> rows(jobs.size());
    ParallelFor(jobs.size(), c.options.threads,
                [&](size_t i) { rows[i] = RunRow(*jobs[i].model, jobs[i].spec); });
    double error[4] = {}, felt[2] = {}, felt_p95 = 0, rise = 0, release = 0, ripple = 0, kick = 0,
           deviation = 0, energy = 1e9;
    for (const Row& r : rows) {
      size_t hand = r.hand == "velocity"      ? 0
                    : r.hand == "force"       ? 1
                    : r.hand == "impedance-1" ? 2
                                              : 3;
      error[hand] = std::max(error[hand], r.m.error_max_n);
      felt[hand != 0] = std::max(felt[hand != 0], r.m.felt_error_rms_n);
      energy = std::min(energy, r.m.energy_min_j - r.m.energy_floor_j);
      if (hand == 0) {
        // 99: not reached. It must fail its goal and still be printed.
        rise = std::max(rise, r.m.rise90_s < 0 ? 99 : r.m.rise90_s / r.m.rise90_floor_s);
        release = std::max(release, r.m.release10_s < 0 ? 99 : r.m.release10_s / r.tau_s);
        ripple = std::max(ripple, r.m.ripple_rms_n);
        kick = std::max(kick, r.m.kick_n);
        felt_p95 = std::max(felt_p95, r.m.felt_error_p95_n);
      } else {
        deviation = std::max(deviation, r.m.deviation_m / m.resolution_m);
      }
    }
    t.rows.push_back({m.title, F(ErrorGoal(m, 0.05, 1.15)), F(error[0]), F(felt[0]), F(felt_p95),
                      F(rise, "%.2f"), F(release, "%.2f"), F(ripple), F(kick), F(error[1]),
                      F(error[2]), F(error[3]), F(felt[1]), F(deviation, "%.1f"),
                      energy >= -1e-12 ? "never under" : "UNDER",
                      F(NanosecondsPerTick(jobs[0].spec), "%.0f")});
    for (Row& r : rows) {
      r.suite = "figures";
      c.findings.rows.push_back(std::move(r));
    }
  }
  c.findings.tables.push_back(std::move(t));
}

// Each law's figures for its time, and which laws are undominated over all figures.
void AddFrontTable(const DeviceModel& m, Findings& findings) {
  const std::vector<Metric>& metrics = FrontMetrics();
  std::vector<LawPoint> points = LawPointsOf(findings.rows, m.name);
  Table t;
  t.title = "Fronts: what a law gives for its time on " + m.title + ", B = 6.5 N s/mm, worst hand";
  t.head = {"law", "ns / tick"};
  auto Any = [&](size_t k) {
    return std::any_of(points.begin(), points.end(),
                       [&](const LawPoint& p) { return std::isfinite(p.figures[k]); });
  };
  for (size_t k = 0; k < metrics.size(); ++k) {
    if (Any(k)) t.head.push_back(metrics[k].label);
  }
  t.head.push_back("on the front of");
  t.head.push_back("undominated over all");
  t.note =
      "Every law that is undominated, and the default. Laws that cycle or are unstable in a hand "
      "are left out; 'never': not reached in a hand.";
  for (const LawPoint& p : points) {
    if (!p.undominated && !p.is_default) continue;
    auto OrNever = [](double v, const char* format) {
      return std::isfinite(v) ? F(v, format) : std::string("never");
    };
    std::vector<std::string> row = {p.name + (p.is_default ? " (default)" : ""),
                                    OrNever(p.ns_per_tick, "%.0f")};
    std::string fronts;
    for (size_t k = 0; k < metrics.size(); ++k) {
      if (!Any(k)) continue;
      row.push_back(OrNever(p.figures[k], "%.3f"));
      if (p.on_front[k]) fronts += std::string(fronts.empty() ? "" : ", ") + metrics[k].id;
    }
    row.push_back(fronts.empty() ? "-" : fronts);
    row.push_back(p.undominated ? "yes" : p.lost ? "no: cycles in a hand" : "no");
    t.rows.push_back(std::move(row));
  }
  findings.tables.push_back(std::move(t));
}

}  // namespace

void RunLawsSuite(SuiteContext& c) {
  AddGoalTable(c);
  Grid grid = GridFor(c.options.quick);
  std::vector<DeviceModel> at_rate;
  for (const DeviceModel& m : c.findings.models) {
    for (double rate : grid.rates_hz) at_rate.push_back(AtRate(m, rate, true));
  }
  std::vector<Job> jobs;
  for (const DeviceModel& m : at_rate) AddJobs(m, grid, &jobs);
  std::vector<Row> rows(jobs.size());
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    rows[i] = RunRow(*jobs[i].model, jobs[i].spec);
    c.progress("laws", ++done, jobs.size());
  });
  std::map<std::string, double> cost;  // measured alone, after the threads are done
  for (size_t i = 0; i < jobs.size(); ++i) {
    rows[i].suite = "laws";
    auto found = cost.find(CostKey(rows[i]));
    if (found == cost.end())
      found = cost.emplace(CostKey(rows[i]), NanosecondsPerTick(jobs[i].spec)).first;
    rows[i].ns_per_tick = found->second;
  }
  size_t from = c.findings.rows.size();
  c.findings.rows.insert(c.findings.rows.end(), rows.begin(), rows.end());
  MarkPareto(c.findings.models, c.findings.rows, from);
  for (const DeviceModel& m : c.findings.models) {
    AddFrontTable(m, c.findings);
    AddTraces(m, c.findings);
    TrialSpec s = SpecOf(m, haptics::kDefaultLaw, kEnamel, kSpeed);
    s.hand = HandKind::kImpedance;
    c.findings.integration_error_m = std::max(c.findings.integration_error_m, IntegrationError(s));
  }
}

}  // namespace enamel::station::lab
