#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/delay.h"
#include "common/scene/own_friction.h"
#include "station/devices/operators.h"
#include "station/lab/suites/exercise_strokes.h"
#include "station/lab/suites/suites.h"

// What a hand feels in the strokes that the built-in exercises are made of, on the devices as they are
// shipped: not measured, with the delay that the station assumes, and calibrated.
namespace enamel::station::lab {
namespace {

constexpr double kHeadline_n_per_mm = 1;
constexpr double kGrips_n_per_mm[] = {kHeadline_n_per_mm, 0.3, 2};

struct Unit {
  DeviceModel model;
  bool calibrated = false;
  haptics::OwnFriction told;
};

// Makes the device that an attempt would use. Calibrated: the law assumes the friction at the lower end of the widest
// interval that counts, and the delay is the profile's.
Result<Unit> UnitOf(const scene::DeviceProfile& shipped, bool calibrated) {
  const int64_t rate_hz = shipped.rate_hz.value;
  const int64_t ticks = calibrated ? shipped.bus_delay_ticks.value
                                   : scene::DelayOfAttached(shipped, nullptr, rate_hz).ticks;
  ENAMEL_ASSIGN_OR_RETURN(const auto profile, scene::WithDelay(shipped, rate_hz, ticks));
  ENAMEL_ASSIGN_OR_RETURN(auto model, ModelOf(profile));
  Unit out{std::move(model), calibrated, {}};
  const double low =
      calibrated ? 1 - 0.01 * static_cast<double>(scene::kMostUncertainty_percent) : 1;
  out.told.c_n = dvec3(out.model.friction_n * low);
  if (!calibrated)
    out.told.half_n_s_per_m = out.model.kc_n_per_m * (scene::kUnmeasuredHalf_us * 1e-6);
  return out;
}

// One list for the lab and the product: the shipped profiles of devices with motors, or the asked one.
std::vector<scene::DeviceProfile> Shipped(const SuiteContext& c) {
  std::vector<scene::DeviceProfile> out;
  if (c.options.profile != "all") {
    for (const DeviceModel& m : c.findings.models) out.push_back(m.profile);
    return out;
  }
  for (scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (scene::HasMotors(p)) out.push_back(std::move(p));
  }
  return out;
}

std::vector<Unit> Units(const SuiteContext& c) {
  std::vector<Unit> out;
  for (const scene::DeviceProfile& p : Shipped(c)) {
    for (const bool calibrated : {false, true}) {
      Result<Unit> unit = UnitOf(p, calibrated);
      // A profile whose delay leaves no coupling has no figures.
      if (unit.ok()) out.push_back(std::move(*unit));
    }
  }
  return out;
}

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

}  // namespace

void RunStrokesSuite(SuiteContext& c) {
  StrokesOptions options;
  options.threads = c.options.threads;
  for (const OperatorPreset& preset : OperatorPresets()) {
    const bool counts = c.options.quick ? preset.name == "dentist" : preset.rank > 0;
    if (counts) options.people.emplace_back(preset.name);
  }
  c.progress("strokes: simulated people", 0, 1);
  const auto strokes = StrokesOfExercises(options);
  // Of built-in documents only.
  ENAMEL_CHECK(strokes.ok());
  const std::vector<Unit> units = Units(c);
  std::vector<StrokeRow>& rows = c.findings.exercise_strokes;
  struct Job {
    const Unit* unit;
    const ExerciseStroke* stroke;
  };
  std::vector<Job> jobs;
  for (const Unit& u : units) {
    for (double grip : kGrips_n_per_mm) {
      if (c.options.quick && grip != kHeadline_n_per_mm) continue;
      for (const ExerciseStroke& s : *strokes) {
        rows.push_back({s.exercise, s.name, u.model.name, u.calibrated, grip, 0, 0,
                        s.b_n_s_per_m * 1e-3, s.speed_m_per_s * 1e3, s.seconds});
        jobs.push_back({&u, &s});
      }
    }
  }
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const auto& [unit, stroke] = jobs[i];
    fidelity::FeltTrial trial;
    trial.b_n_s_per_m = Sym3::Isotropic(stroke->b_n_s_per_m);
    trial.hand.stiffness_n_per_m = rows[i].hand_n_per_mm * 1e3;
    trial.delay_ticks = unit->model.delay_ticks;
    trial.friction = unit->told;
    trial.ideal = false;
    const auto felt = Feel(FeltDeviceOf(unit->model), trial, stroke->way_m);
    rows[i].felt_error_rms_n = felt.felt_error_rms_n;
    rows[i].tool_rms_n = felt.tool_rms_n;
    c.progress("strokes: hands", ++done, jobs.size());
  });
  AddStrokeTables(c, units);
}

}  // namespace enamel::station::lab
