#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "station/lab/laws/motions.h"
#include "station/lab/laws/swings.h"
#include "station/lab/suites/suites.h"

// How many swings the watch sees, how soon, and how often it sees one where there is none. Devices as their
// profiles say, with the profile's delay and with the delay that a station assumes of an attached one.
namespace enamel::station::lab {
namespace {

// Right profiles are asked as often as all wrong ones together.
constexpr int kRight = 10'000, kWrong = 10'000, kQuickRight = 140, kQuickWrong = 280;
constexpr double kSoon_s = 0.2;
constexpr double kRecordedSpeeds_m_per_s[] = {0.2e-3, 2e-3, 10e-3},
                 kRecordedGrips_n_per_m[] = {300, 1000, 5000};

// The watch as it is, and what other numbers would do.
const std::vector<haptics::SwingWatchParams>& Settings() {
  static const std::vector<haptics::SwingWatchParams> kSettings = [] {
    std::vector<haptics::SwingWatchParams> out = {{}};
    for (int half_cycles : {5, 6, 8})
      for (double least_n : {0.2, 0.25, 0.3, 0.35, 0.45, 0.6})
        out.push_back({.least_n = least_n, .half_cycles = half_cycles});
    return out;
  }();
  return kSettings;
}

struct Outcome {
  std::optional<double> begins_s;
  std::vector<std::optional<double>> seen_s;  // of each setting
  double swing_n = 0, left_n = 0;  // peak to peak in the last second: looked at, and held
};

struct Job {
  const DeviceModel* model;
  const ProfileError* error;
  SwingTrial trial;
  bool recorded = false;
  Outcome out;
};

void Run(Job* job) {
  const DeviceModel& m = *job->model;
  const bool right = job->error == &ProfileErrors().front();
  const std::vector<dvec3> force = RunSwingTrial(m, job->trial, *job->error, false);
  Outcome& out = job->out;
  if (!right) {
    out.begins_s = SwingBegins(force, m.tick_s());
    // What swings with the right profile too is the hand's doing.
    if (out.begins_s &&
        SwingBegins(RunSwingTrial(m, job->trial, ProfileErrors().front(), false), m.tick_s()))
      out.begins_s.reset();
    if (out.begins_s) {
      out.swing_n = SwingLeft(force, m.tick_s());
      out.left_n = SwingLeft(RunSwingTrial(m, job->trial, *job->error, true), m.tick_s());
    }
  }
  for (haptics::SwingWatchParams w : Settings()) {
    w.tick_s = m.tick_s();
    out.seen_s.push_back(SwingSeen(force, w));
  }
}

std::vector<Job> Jobs(const SuiteContext& c, const std::vector<Unit>& units) {
  std::vector<Job> out;
  const std::vector<ProfileError>& errors = ProfileErrors();
  const auto add = [&](int n, bool right) {
    for (int i = 0; i < n; ++i) {
      Random random(c.options.seed + static_cast<uint64_t>(out.size()) * 7 * Random::kStep);
      const auto k = static_cast<size_t>(i);
      const Unit& unit = units[k % units.size()];
      const DeviceModel& m = unit.model;
      const SwingHand hand = kSwingHands[k / units.size() % std::size(kSwingHands)];
      const ProfileError& error =
          right
              ? errors.front()
              : errors[1 + static_cast<size_t>(random.Below(static_cast<int>(errors.size()) - 1))];
      // Half of the right profiles in hands that damp as little as those that swing.
      const bool light = !right || random.Uniform() < 0.5;
      out.push_back({&m, &error, DrawSwingTrial(hand, m, light, random), false, {}});
      out.back().trial.told = unit.told;
    }
  };
  add(c.options.quick ? kQuickRight : kRight, true);
  add(c.options.quick ? kQuickWrong : kWrong, false);
  if (c.options.motion.empty()) return out;
  const auto recorded = RecordedMotions(c.options.motion);
  // Checked before the first suite.
  ENAMEL_CHECK(recorded.ok());
  for (const HandMotion& motion : *recorded) {
    for (double speed : kRecordedSpeeds_m_per_s) {
      for (double grip : kRecordedGrips_n_per_m) {
        for (const Unit& unit : units) {
          const DeviceModel& m = unit.model;
          Job job{&m, &errors.front(), {}, true, {}};
          job.trial.told = unit.told;
          job.trial.hand = SwingHand::kGrip;
          job.trial.stiffness_n_per_m = grip;
          job.trial.damping_n_s_per_m = 1.2 * std::sqrt(grip * (job.trial.mass_kg + m.mass_kg));
          job.trial.b_n_s_per_m = 6500;
          job.trial.way_m = ScaledToSpeed(motion, speed).way_m;
          job.trial.seconds = static_cast<double>(job.trial.way_m.size() - 1) * kWayStep_s;
          out.push_back(std::move(job));
        }
      }
    }
  }
  return out;
}

struct Count {
  int swings = 0, caught = 0, soon = 0, right = 0, false_alarms = 0;
  double sum_s = 0, longest_s = 0;
};

Count CountOf(const std::vector<Job>& jobs, size_t setting) {
  Count out;
  for (const Job& j : jobs) {
    const std::optional<double>& seen = j.out.seen_s[setting];
    if (j.error == &ProfileErrors().front()) {
      ++out.right;
      out.false_alarms += seen.has_value();
    } else if (j.out.begins_s) {
      ++out.swings;
      if (!seen) continue;
      const double within = std::max(0.0, *seen - *j.out.begins_s);
      ++out.caught;
      out.soon += within <= kSoon_s;
      out.sum_s += within;
      out.longest_s = std::max(out.longest_s, within);
    }
  }
  return out;
}

double Share(int part, int whole) { return whole > 0 ? static_cast<double>(part) / whole : 0; }

void AddCurve(const std::vector<Job>& jobs, std::vector<Table>* tables) {
  Table t;
  t.title = "The watch for swings: caught, in time, and false alarms, by its two numbers";
  t.note =
      "A swing: the sent force, less its mean over a tenth of a second, passes 1 N peak to peak "
      "and stays "
      "above it for half a second, and does not with the right profile. Caught within: from when "
      "it "
      "passes 1 N. False alarms: on devices that are what their profiles say.";
  t.head = {"N",      "half cycles", "swings",      "caught %",    "within 0.2 s %",
            "mean s", "longest s",   "right hands", "false alarms"};
  for (size_t i = 0; i < Settings().size(); ++i) {
    const haptics::SwingWatchParams& w = Settings()[i];
    const Count n = CountOf(jobs, i);
    t.rows.push_back(
        {F(w.least_n, "%.2f") + (i == 0 ? " (as it is)" : ""), std::to_string(w.half_cycles),
         std::to_string(n.swings), F(100 * Share(n.caught, n.swings), "%.1f"),
         F(100 * Share(n.soon, n.swings), "%.1f"), F(n.caught > 0 ? n.sum_s / n.caught : 0, "%.2f"),
         F(n.longest_s, "%.2f"), std::to_string(n.right), std::to_string(n.false_alarms)});
  }
  tables->push_back(std::move(t));
}

std::string HandOf(const Job& j) { return j.recorded ? "recorded" : NameOf(j.trial.hand); }

void AddRows(const std::vector<Job>& jobs, std::vector<WatchRow>* rows) {
  for (const Job& j : jobs) {
    auto row = std::find_if(rows->begin(), rows->end(), [&](const WatchRow& r) {
      return r.device == j.model->name && r.delay_ticks == j.model->delay_ticks &&
             r.hand == HandOf(j) && r.error == j.error->name;
    });
    if (row == rows->end()) {
      rows->push_back({j.model->name, HandOf(j), j.error->name, j.model->delay_ticks});
      row = rows->end() - 1;
    }
    const std::optional<double>& seen = j.out.seen_s.front();
    ++row->trials;
    if (j.error == &ProfileErrors().front()) row->false_alarms += seen.has_value();
    if (!j.out.begins_s) continue;
    ++row->swings;
    row->swing_n = std::max(row->swing_n, j.out.swing_n);
    row->left_n = std::max(row->left_n, j.out.left_n);
    if (!seen) continue;
    const double within_s = std::max(0.0, *seen - *j.out.begins_s);
    ++row->caught;
    row->soon += within_s <= kSoon_s;
    row->within_s += (within_s - row->within_s) / row->caught;
  }
}

void AddByError(const std::vector<Job>& jobs, std::vector<Table>* tables) {
  Table t;
  t.title = "Swings by what is wrong in the profile, and what the watch leaves of them";
  t.note =
      "Peak to peak in the last second of 4 s, without the watch and with it: median, and the "
      "largest of 95 % "
      "of the swings.";
  t.head = {"profile's error", "trials", "swings", "caught", "within 0.2 s", "without N", "with N"};
  for (const ProfileError& e : ProfileErrors()) {
    std::vector<double> without, with;
    int trials = 0, caught = 0, soon = 0;
    for (const Job& j : jobs) {
      if (j.error != &e) continue;
      ++trials;
      if (!j.out.begins_s) continue;
      without.push_back(j.out.swing_n);
      with.push_back(j.out.left_n);
      const std::optional<double>& seen = j.out.seen_s.front();
      caught += seen.has_value();
      soon += seen && *seen - *j.out.begins_s <= kSoon_s;
    }
    if (&e == &ProfileErrors().front()) continue;
    std::sort(without.begin(), without.end());
    std::sort(with.begin(), with.end());
    const auto text = [](const std::vector<double>& v) {
      if (v.empty()) return std::string("–");
      return F(v[v.size() / 2], "%.1f") + ", " + F(v[(v.size() - 1) * 95 / 100], "%.1f");
    };
    t.rows.push_back({e.name, std::to_string(trials), std::to_string(without.size()),
                      std::to_string(caught), std::to_string(soon), text(without), text(with)});
  }
  tables->push_back(std::move(t));
}

}  // namespace

void RunWatchSuite(SuiteContext& c) {
  const std::vector<Unit> units = UnitsOf(c.findings.models);
  std::vector<Job> jobs = Jobs(c, units);
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    Run(&jobs[i]);
    c.progress("watch", ++done, jobs.size());
  });
  AddCurve(jobs, &c.findings.tables);
  AddByError(jobs, &c.findings.tables);
  AddRows(jobs, &c.findings.watch);
}

}  // namespace enamel::station::lab
