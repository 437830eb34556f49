#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "common/fidelity/budget.h"
#include "station/devices/operators.h"
#include "station/lab/laws/motions.h"
#include "station/lab/suites/exercise_strokes.h"
#include "station/lab/suites/suites.h"

// What a hand feels in the strokes that the built-in exercises are made of, on the devices as they are
// shipped: not measured, with the delay that the station assumes, and calibrated.
namespace enamel::station::lab {
namespace {

constexpr double kHeadline_n_per_mm = 1;
constexpr double kGrips_n_per_mm[] = {kHeadline_n_per_mm, 0.3, 2};

struct Felt {
  double error = kNotApplicable;   // RMS error over RMS force, both over the time of removal
  double within = kNotApplicable;  // share of that time in strokes within fidelity::kShares[1]
};

// Over the strokes of one exercise, or of all.
Felt FeltIn(const std::vector<StrokeRow>& rows, const Unit& unit, double grip,
            const std::string& exercise) {
  double error2 = 0, tool2 = 0, within_s = 0, all_s = 0;
  for (const StrokeRow& r : rows) {
    if (r.device != unit.model.name || r.calibrated != unit.calibrated || r.hand_n_per_mm != grip ||
        (!exercise.empty() && r.exercise != exercise))
      continue;
    error2 += r.removal_s * r.felt_error_rms_n * r.felt_error_rms_n;
    tool2 += r.removal_s * r.tool_rms_n * r.tool_rms_n;
    all_s += r.removal_s;
    if (r.felt_error() <= fidelity::kShares[1]) within_s += r.removal_s;
  }
  if (!(tool2 > 0)) return {};
  return {std::sqrt(error2 / tool2), within_s / all_s};
}

void AddStrokeTables(SuiteContext& c, const std::vector<Unit>& units) {
  const std::vector<StrokeRow>& rows = c.findings.exercise_strokes;
  std::vector<std::string> exercises;
  for (const StrokeRow& r : rows)
    if (std::find(exercises.begin(), exercises.end(), r.exercise) == exercises.end())
      exercises.push_back(r.exercise);
  Table t;
  t.title = "Felt error in the strokes of the built-in exercises, %, grip 1 N/mm";
  t.note =
      "RMS of the force in the hand less that on an ideal tool, over the RMS of the latter, both "
      "over the "
      "time in which simulated people remove tissue. In brackets grips of 0.3 and 2 N/mm. Within: "
      "share of "
      "that time in strokes that are within 15 %. Not calibrated: with the delay that a station "
      "assumes of "
      "an attached device, and Kc lowered to it. Calibrated: with the profile's delay, friction "
      "told 15 % "
      "too low.";
  t.head = {"device", "calibrated", "Kc N/mm", "delay", "all", "within %"};
  for (const std::string& e : exercises) t.head.push_back(e);
  for (const Unit& u : units) {
    const Felt felt = FeltIn(rows, u, kHeadline_n_per_mm, "");
    std::string all = F(100 * felt.error, "%.1f");
    if (!c.options.quick)
      all += " (" + F(100 * FeltIn(rows, u, 0.3, "").error, "%.0f") + ", " +
             F(100 * FeltIn(rows, u, 2, "").error, "%.0f") + ")";
    std::vector<std::string> line = {u.model.title,
                                     u.calibrated ? "yes" : "no",
                                     F(u.model.kc_n_per_m * 1e-3),
                                     std::to_string(u.model.delay_ticks),
                                     all,
                                     F(100 * felt.within, "%.0f")};
    for (const std::string& e : exercises)
      line.push_back(F(100 * FeltIn(rows, u, kHeadline_n_per_mm, e).error, "%.0f"));
    t.rows.push_back(std::move(line));
  }
  c.findings.tables.push_back(std::move(t));
}

fidelity::FeltTrial TrialOf(const Unit& unit, const fidelity::CutStroke& stroke, double grip) {
  return fidelity::TrialOf(stroke, grip * 1e3, unit.model.delay_ticks, unit.told);
}

// What makes the error of the calibrated devices, from every kEach-th stroke: a budget takes nine simulations.
void AddCauses(SuiteContext& c, const std::vector<Unit>& units,
               const std::vector<ExerciseStroke>& strokes) {
  constexpr size_t kEach = 8;
  std::vector<const Unit*> calibrated;
  for (const Unit& u : units)
    if (u.calibrated) calibrated.push_back(&u);
  Table t;
  t.title = "What the error in these strokes is made of, % of its square, calibrated, grip 1 N/mm";
  t.note =
      "Spring: what lags behind it, and what the law makes of that. A cause that takes error away "
      "is below 0.";
  t.head = {"device", "spring", "friction", "mass", "damping", "cells", "delay", "ceiling"};
  std::vector<std::vector<std::string>> lines(calibrated.size());
  std::atomic<size_t> done{0};
  ParallelFor(calibrated.size(), c.options.threads, [&](size_t i) {
    const Unit& u = *calibrated[i];
    std::map<std::string, double> share;
    double whole = 0;
    for (size_t k = 0; k < strokes.size(); k += kEach) {
      const auto budget = fidelity::BudgetOf(
          FeltDeviceOf(u.model), TrialOf(u, strokes[k], kHeadline_n_per_mm), strokes[k].way_m);
      const double square = strokes[k].seconds * budget.rms_n * budget.rms_n;
      whole += square;
      for (const fidelity::FeltPart& part : budget.parts) share[part.cause] += part.share * square;
    }
    lines[i] = {u.model.title};
    for (const double sum :
         {share["lag"] + share["law"], share["friction"], share["inertia"], share["damping"],
          share["quantisation"], share["delay"], share["saturation"]})
      lines[i].push_back(F(whole > 0 ? 100 * sum / whole : 0, "%.0f"));
    c.progress("strokes: causes", ++done, calibrated.size());
  });
  t.rows = std::move(lines);
  c.findings.tables.push_back(std::move(t));
}

// Recorded motions of people, at their own speed, in tissues that the built-in exercises consist of.
std::vector<ExerciseStroke> RecordedStrokes(const std::vector<HandMotion>& motions) {
  constexpr std::pair<const char*, double> kTissues[] = {
      {"slot", 3560}, {"widening", 890}, {"dentin", 530}, {"finishing", 180}, {"caries", 100}};
  std::vector<ExerciseStroke> out;
  for (const HandMotion& motion : motions) {
    for (const auto& [tissue, b] : kTissues) {
      ExerciseStroke s;
      s.way_m = motion.way_m;
      const dvec3 from = s.way_m.front();
      for (dvec3& x : s.way_m) x -= from;
      s.b_n_s_per_m = b;
      s.speed_m_per_s = MeanSpeed(motion);
      s.seconds = static_cast<double>(s.way_m.size()) * kWayStep_s;
      s.exercise = "recorded";
      s.name = motion.name + " " + tissue;
      out.push_back(std::move(s));
    }
  }
  return out;
}

// Of built-in documents, or the recordings that were asked for; both are known to be readable.
std::vector<ExerciseStroke> StrokesAskedFor(SuiteContext& c) {
  if (!c.options.motion.empty()) {
    const auto motions = RecordedMotions(c.options.motion);
    ENAMEL_CHECK(motions.ok());
    return RecordedStrokes(*motions);
  }
  StrokesOptions options;
  options.threads = c.options.threads;
  for (const OperatorPreset& preset : OperatorPresets()) {
    const bool counts = c.options.quick ? preset.name == "dentist" : preset.rank > 0;
    if (counts) options.people.emplace_back(preset.name);
  }
  c.progress("strokes: simulated people", 0, 1);
  auto strokes = StrokesOfExercises(options);
  ENAMEL_CHECK(strokes.ok());
  return std::move(*strokes);
}

}  // namespace

void RunStrokesSuite(SuiteContext& c) {
  const std::vector<ExerciseStroke> strokes = StrokesAskedFor(c);
  const std::vector<Unit> units = UnitsOf(c.findings.models);
  std::vector<StrokeRow>& rows = c.findings.exercise_strokes;
  struct Job {
    const Unit* unit;
    const ExerciseStroke* stroke;
  };
  std::vector<Job> jobs;
  for (const Unit& u : units) {
    for (double grip : kGrips_n_per_mm) {
      if (c.options.quick && grip != kHeadline_n_per_mm) continue;
      for (const ExerciseStroke& s : strokes) {
        rows.push_back({s.exercise, s.name, u.model.name, u.calibrated, grip, 0, 0,
                        s.b_n_s_per_m * 1e-3, s.speed_m_per_s * 1e3, s.seconds});
        jobs.push_back({&u, &s});
      }
    }
  }
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const auto& [unit, stroke] = jobs[i];
    const auto felt = Feel(FeltDeviceOf(unit->model),
                           TrialOf(*unit, *stroke, rows[i].hand_n_per_mm), stroke->way_m);
    rows[i].felt_error_rms_n = felt.felt_error_rms_n;
    rows[i].tool_rms_n = felt.tool_rms_n;
    c.progress("strokes: hands", ++done, jobs.size());
  });
  AddStrokeTables(c, units);
  if (!c.options.quick) AddCauses(c, units, strokes);
}

}  // namespace enamel::station::lab
