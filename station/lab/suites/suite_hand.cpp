#include <algorithm>
#include <atomic>
#include <cmath>

#include "station/lab/laws/hand_trial.h"
#include "station/lab/laws/withdrawal.h"
#include "station/lab/suites/suites.h"

// Motions of hands instead of constant speeds: strokes that turn, stop and slip, recorded people,
// first strokes from slow to fast, and withdrawals with the product's own core.
namespace enamel::station::lab {
namespace {

constexpr double kSpeed_m_per_s = 0.43e-3;      // of the paper's cuts
constexpr double kHumanSpeed_m_per_s = 0.2e-3;  // mean; a recording's peaks are five times that
const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

struct Grip {
  const char* name;
  HandKind kind;
  double stiffness;
};
constexpr Grip kGrips[] = {{"velocity", HandKind::kVelocity, 0},
                           {"force", HandKind::kForce, 0},
                           {"impedance-1", HandKind::kImpedance, 1000},
                           {"impedance-0.2", HandKind::kImpedance, 200}};

struct Job {
  DeviceModel model;
  HandTrial trial;
  HandMotion motion;
  const char* hand = "velocity";
  const char* lattice = "cartesian";
};

// Joints turned against the axes of space, and a driver that rounds to cells of the same edge.
Lattice Turned(double cell_m, bool rounds) {
  Lattice l;
  dvec3 x = glm::normalize(dvec3(0.8, 0.5, -0.3)),
        y = glm::normalize(glm::cross(dvec3(0, 0.2, 1), x));
  l.joints = glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
  l.driver_cell_m = rounds ? cell_m : 0;
  return l;
}

Job JobOf(const DeviceModel& m, double b, const HandMotion& motion) {
  Job job{m, {}, motion};
  job.trial.b_n_s_per_m = b;
  return job;
}

// The motions for every device and hand.
std::vector<HandMotion> Motions(const DeviceModel& m, double b,
                                const std::vector<HandMotion>& recorded) {
  std::vector<HandMotion> all;
  // People at different paces are compared at one mean speed, with their own shape.
  for (const HandMotion& r : recorded) all.push_back(ScaledToSpeed(r, kHumanSpeed_m_per_s));
  all.push_back(WanderingMotion(kHumanSpeed_m_per_s, 12, 1));
  for (double stroke : {1.0, 0.5}) {
    all.push_back(StrokesMotion(kSpeed_m_per_s, stroke, 8, kOblique));
    all.back().name = stroke == 1 ? "strokes-1s" : "strokes-0.5s";
  }
  // Until the plain coupling has settled to a hundredth.
  double settle = std::max(2.0, 4.6 * b / m.kc_n_per_m);
  all.push_back(ReversalMotion(kSpeed_m_per_s, settle, 4, kOblique));
  all.push_back(CircleMotion(kSpeed_m_per_s, 0.5e-3));
  all.push_back(CornerMotion(kSpeed_m_per_s, 3));
  all.push_back(TremorMotion(kSpeed_m_per_s, 0.1e-3, 6, 1));
  return all;
}

// First strokes from rest at constant speed, wherever B v is within the continuous force.
void AddFirstStrokes(const DeviceModel& m, bool quick, std::vector<Job>* jobs) {
  const double most =
      std::min(0.9 * m.peak_force_n, m.continuous_force_n > 0 ? m.continuous_force_n : 1e9);
  for (double b : {30.0, 100.0, 300.0, 1000.0, 6500.0}) {
    for (double v : {0.1e-3, 0.2e-3, 0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3, 100e-3}) {
      // Above the motors' force nothing can be rendered; below 0.02 N nobody feels it.
      if (b * v > most || b * v < 0.02 || (quick && v != 0.5e-3 && v != 5e-3 && v != 50e-3))
        continue;
      double for_s = std::clamp(10 * b / m.kc_n_per_m, 0.3, 2.0);
      Job job = JobOf(m, b, ReversalMotion(v, for_s, 0, kOblique));
      job.motion.name = "first-stroke";
      job.motion.reversal_s = -1;
      jobs->push_back(std::move(job));
    }
  }
}

std::vector<Job> JobsFor(const DeviceModel& m, bool quick,
                         const std::vector<HandMotion>& recorded) {
  std::vector<Job> jobs;
  for (double b : {6500.0, 1000.0, 300.0}) {
    for (const HandMotion& motion : Motions(m, b, recorded)) {
      for (const Grip& grip : kGrips) {
        // Only this hand shows the law's own times (front.cpp).
        if (quick && grip.kind != HandKind::kVelocity) continue;
        Job job = JobOf(m, b, motion);
        job.trial.hand = grip.kind;
        job.trial.hand_stiffness_n_per_m = grip.stiffness;
        job.hand = grip.name;
        jobs.push_back(std::move(job));
      }
    }
  }
  AddFirstStrokes(m, quick, &jobs);
  for (const HandMotion& motion : Motions(m, 6500, recorded)) {
    for (bool rounds : {false, true}) {
      Job job = JobOf(m, 6500, motion);
      job.trial.lattice = Turned(m.resolution_m, rounds);
      job.lattice = rounds ? "turned-rounded" : "turned";
      jobs.push_back(std::move(job));
    }
    // One tick of delay, at the stiffness its clause allows; other rates, with the stiffness of
    // theirs.
    Job late = JobOf(m, 6500, motion);
    late.model.delay_ticks = late.trial.delay_ticks = 1;
    late.model.kc_n_per_m = std::min(m.kc_n_per_m, late.model.PassiveKc(m.rate_hz));
    jobs.push_back(std::move(late));
    if (quick) continue;
    for (double rate : {2000.0, 4000.0, 8000.0}) {
      jobs.push_back(JobOf(AtRate(m, rate, true), 6500, motion));
    }
  }
  return jobs;
}

HandRow RowOf(const Job& job, const HandFigures& f) {
  HandRow row;
  row.device = job.model.name;
  row.b_n_s_per_mm = job.trial.b_n_s_per_m * 1e-3;
  row.rate_hz = job.model.rate_hz;
  row.kc_n_per_mm = job.model.kc_n_per_m * 1e-3;
  row.delay_ticks = job.trial.delay_ticks;
  row.motion = job.motion.name;
  row.hand = job.hand;
  row.lattice = job.lattice;
  row.law = haptics::FindLaw(job.trial.law)->name;
  row.has_track = true;
  row.f = f;
  return row;
}

// `pull_n` is relative to the path in; see Withdrawal.
void AddWithdrawals(SuiteContext& c, const DeviceModel& m, const cutting::Volume& block) {
  struct Case {
    const NamedBur* bur;
    Withdrawal w;
  };
  std::vector<Case> cases;
  for (const NamedBur& bur : WithdrawalBurs()) {
    for (Cut cut : kCuts) {
      for (bool turned : {false, true}) {
        for (double speed : {0.01, 0.03, 0.05}) {
          for (double hand : {0.0, 1000.0}) {
            if (c.options.quick && (speed < 0.05 || turned)) continue;
            Withdrawal w{bur.bur, cut, speed, turned, haptics::kDefaultLaw, hand};
            w.kc_n_per_m = m.kc_n_per_m;
            w.cell_m = m.resolution_m;
            w.peak_force_n = m.peak_force_n;
            cases.push_back({&bur, w});
          }
        }
      }
    }
  }
  std::vector<HandRow> rows(cases.size());
  std::atomic<size_t> done{0};
  ParallelFor(cases.size(), c.options.threads, [&](size_t i) {
    const Withdrawal& w = cases[i].w;
    WithdrawalFigures f = RunWithdrawal(w, block);
    HandRow& row = rows[i];
    row.device = m.name;
    row.b_n_s_per_mm = 6.5;
    row.rate_hz = 1000;
    row.kc_n_per_mm = m.kc_n_per_m * 1e-3;
    row.motion = std::string("withdraw-") + CutName(w.cut) + "-" + cases[i].bur->name +
                 (w.turned ? "-turned-" : "-") +
                 std::to_string(static_cast<int>(std::lround(w.speed_m_per_s * 1e3))) + "mm_s";
    row.hand = w.hand_n_per_m > 0 ? "impedance-1" : "velocity";
    row.lattice = "cartesian";
    row.law = haptics::FindLaw(w.law)->name;
    row.opposing_n = f.opposing_n;
    row.pull_n = f.opposing_n > std::max(0.15, m.kc_n_per_m * m.resolution_m)
                     // One encoder cell causes Kc delta, which is not charged to the law of a
                     // coarse device.
                     ? f.opposing_n - m.kc_n_per_m * m.resolution_m
                     : f.opposing_n;
    row.rise_n = f.rise_n;
    row.step_n = std::max(0.0, f.other_n);
    c.progress("hand: withdrawals", ++done, cases.size());
  });
  for (HandRow& row : rows) c.findings.hands.push_back(std::move(row));
}

// The goals' figures, a line per device: the worst of the rows.
void AddTable(SuiteContext& c, size_t from) {
  Table t;
  t.title =
      "A hand's motions: the default law, delay 0, 1 kHz, velocity hand, cells along the axes";
  t.note =
      "Human: recordings if there are any, else the generated wandering hand. Error over oracle: "
      "RMS of R - "
      "B v over that of the track that rises by at most Kc |v| T a tick. Pull: largest force "
      "against a withdrawal.";
  t.head = {"device",
            "human 6.5 / oracle",
            "lag ms",
            "human 1 %",
            "human 0.3 %",
            "help s",
            "strokes 1 s %",
            "circle deg",
            "overshoot",
            "pull N",
            "turned lattice / cartesian error"};
  for (const DeviceModel& m : c.findings.models) {
    double over = 0, lag = 0, one = 0, third = 0, help = 0, stroke = 0, circle = 0, shoot = 0,
           pull = 0;
    double e2 = 0, o2 = 0, e1 = 0, i1 = 0, e3 = 0, i3 = 0, turned2 = 0, straight2 = 0;
    int humans = 0;
    bool recorded =
        std::any_of(c.findings.hands.begin() + static_cast<long>(from), c.findings.hands.end(),
                    [](const HandRow& r) { return r.motion.starts_with("human-"); });
    for (size_t i = from; i < c.findings.hands.size(); ++i) {
      const HandRow& r = c.findings.hands[i];
      if (r.device != m.name || r.hand != "velocity" || r.delay_ticks > 0 || r.rate_hz != m.rate_hz)
        continue;
      // The generated hand is only used without recorded people.
      bool human = r.motion.starts_with("human-") || (!recorded && r.motion == "wandering");
      bool straight = r.lattice == "cartesian", hard = r.b_n_s_per_mm == 6.5;
      if (!r.has_track) pull = std::max(pull, r.pull_n);
      if (human && hard && straight) {
        // Adds squares, not ratios: motions differ in length and force.
        e2 += r.f.error_rms_n * r.f.error_rms_n;
        o2 += r.f.oracle_rms_n * r.f.oracle_rms_n;
        straight2 += r.f.error_rms_n * r.f.error_rms_n;
        lag += r.f.lag_s;
        ++humans;
      }
      if (human && hard && r.lattice == "turned") turned2 += r.f.error_rms_n * r.f.error_rms_n;
      if (human && straight && r.b_n_s_per_mm == 1) {
        e1 += r.f.error_rms_n * r.f.error_rms_n;
        i1 += r.f.ideal_rms_n * r.f.ideal_rms_n;
      }
      if (human && straight && r.b_n_s_per_mm == 0.3) {
        e3 += r.f.error_rms_n * r.f.error_rms_n;
        i3 += r.f.ideal_rms_n * r.f.ideal_rms_n;
      }
      if (!straight) continue;
      if (r.motion == "first-stroke") {
        // As in ErrorGoal: within it, the difference is the encoder's grain, not overshoot.
        double allowed = std::max(0.05, 1.15 * m.kc_n_per_m * m.resolution_m / 2);
        if (r.f.excess_n > allowed) shoot = std::max(shoot, r.f.overshoot);
      }
      if (!hard) continue;
      if (r.motion == "reversal") help = r.f.help_s;
      if (r.motion == "strokes-1s") stroke = r.f.error_rms_n / r.f.ideal_rms_n;
      if (r.motion == "circle") circle = r.f.direction_deg;
    }
    over = o2 > 0 ? std::sqrt(e2 / o2) : 0;
    one = i1 > 0 ? std::sqrt(e1 / i1) : 0;
    third = i3 > 0 ? std::sqrt(e3 / i3) : 0;
    t.rows.push_back({m.title, F(over, "%.2f"), F(humans ? 1e3 * lag / humans : 0, "%.0f"),
                      F(100 * one, "%.0f"), F(100 * third, "%.0f"), F(help, "%.2f"),
                      F(100 * stroke, "%.0f"), F(circle, "%.0f"), F(shoot, "%.2f"), F(pull),
                      F(straight2 > 0 ? std::sqrt(turned2 / straight2) : 0, "%.2f")});
  }
  c.findings.tables.push_back(std::move(t));
}

// The anchored laws' results with a hand, for the fronts against run time.
void AddFrontRows(SuiteContext& c, const DeviceModel& m, const cutting::Volume& block) {
  for (haptics::LawKind law : {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell}) {
    HandTrial trial;
    trial.law = law;
    HandFigures f = RunHand(m, trial, WanderingMotion(kHumanSpeed_m_per_s, 12, 1));
    double pull = 0;
    for (const NamedBur& bur : WithdrawalBurs()) {
      Withdrawal w{bur.bur, Cut::kSideMill, 0.05, false, law};
      w.kc_n_per_m = m.kc_n_per_m;
      w.cell_m = m.resolution_m;
      w.peak_force_n = m.peak_force_n;
      pull = std::max(pull, RunWithdrawal(w, block).opposing_n);
    }
    TrialSpec spec = SpecOf(m, law, 6500, kSpeed_m_per_s);
    Row row = RunRow(m, spec);
    row.suite = "hand-front";
    row.title = "wandering hand, side-milling burs pulled back at 50 mm/s";
    row.ns_per_tick = NanosecondsPerTick(spec);
    row.extra = {{"error_over_oracle", f.error_rms_n / f.oracle_rms_n}, {"pull_n", pull}};
    c.findings.rows.push_back(std::move(row));
  }
}

}  // namespace

void RunHandSuite(SuiteContext& c) {
  std::vector<HandMotion> recorded;
  Result<std::vector<HandMotion>> found = RecordedMotions(c.options.recordings);
  if (found.ok()) recorded = std::move(*found);
  // A named folder that cannot be read; a missing default one is reported below.
  if (!found.ok() && c.options.errors) c.options.errors(found.status().message());
  if (recorded.empty() && c.options.out != nullptr) {
    std::fprintf(
        c.options.out,
        "hand: no recordings in %s, so only generated motions; --recordings names a folder\n",
        c.options.recordings.c_str());
  }
  size_t from = c.findings.hands.size();
  cutting::Volume block = WithdrawalBlock();
  for (const DeviceModel& m : c.findings.models) {
    std::vector<Job> jobs = JobsFor(m, c.options.quick, recorded);
    std::vector<HandRow> rows(jobs.size());
    std::atomic<size_t> done{0};
    ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
      rows[i] = RowOf(jobs[i], RunHand(jobs[i].model, jobs[i].trial, jobs[i].motion));
      c.progress("hand: motions", ++done, jobs.size());
    });
    for (HandRow& row : rows) c.findings.hands.push_back(std::move(row));
    AddWithdrawals(c, m, block);
    AddFrontRows(c, m, block);
  }
  AddTable(c, from);
}

}  // namespace enamel::station::lab
