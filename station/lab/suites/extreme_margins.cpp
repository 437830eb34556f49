#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>

#include "station/lab/suites/extreme_cases.h"

namespace enamel::station::lab {
namespace {

constexpr double kSpeed_m_per_s = 0.43e-3, kEnamel_n_s_per_m = 6500;

// A loose, an ordinary and a firm grip, N/m, and a hand that only pushes (0).
constexpr std::array<double, 4> kGrips_n_per_m = {300, 1000, 5000, 0};

// How far from its line a tip may be that is held still but for its encoder: a cell on each of three axes, and as much
// again for the spring's answer, rounded down.
constexpr double kCells = 2.5;

std::string NameOfGrip(double grip) { return grip == 0 ? "push" : F(grip * 1e-3, "%g N/mm"); }

TrialSpec InHand(const DeviceModel& m, double grip) {
  TrialSpec s = SpecOf(m, haptics::kDefaultLaw, kEnamel_n_s_per_m, kSpeed_m_per_s);
  s.hand = grip == 0 ? HandKind::kForce : HandKind::kImpedance;
  s.hand_stiffness_n_per_m = grip;
  s.hand_damping_n_s_per_m = grip == 0 ? 2 : 4;
  s.direction = glm::normalize(dvec3(1, 2, 3));
  s.settle_s = 1.5;
  s.window_s = 1;
  s.measure_release = false;
  s.trace_s = m.tick_s();
  return s;
}

struct Outcome {
  Measurement m;
  Verdict stability;
  bool proved;
};

Outcome Cut(const TrialSpec& s) {
  Outcome o{RunTrial(s), Verdict::kStable, Proved(s)};
  const bool off = o.m.deviation_m > kCells * s.plant.resolution_m;
  // A swing of a tenth of a millimetre, or of forty cells, with a force that the hand feels as buzz.
  const bool swings =
      o.m.unstable || (o.m.deviation_m > std::max(40 * s.plant.resolution_m, 50e-6) &&
                       o.m.ripple_fast_rms_n > 0.05);
  o.stability = swings                       ? Verdict::kUnstable
                : o.proved && !o.m.violation ? Verdict::kPassive
                : off && o.m.cycle           ? Verdict::kBounded
                                             : Verdict::kStable;
  return o;
}

// Whether every force was finite and within what the motors give on three axes.
bool WithinPeak(const DeviceModel& m, const Measurement& found) {
  return std::all_of(found.trace.begin(), found.trace.end(), [&](const Sample& q) {
    return std::abs(q.force_n) <= std::sqrt(3.0) * m.peak_force_n * (1 + 1e-9);
  });
}

ExtremeRow RowOf(const DeviceModel& m, const std::string& name, double grip, const Outcome& o) {
  ExtremeRow row;
  row.name = name;
  row.device = m.name;
  row.hand = NameOfGrip(grip);
  row.within_peak = WithinPeak(m, o.m);
  row.stability = o.stability;
  row.command_error_rms_n = o.m.error_rms_n;
  row.felt_error_rms_n = o.m.felt_error_rms_n;
  return row;
}

struct Timing {
  const char* name;
  double jitter, drop, mode_hz;
};
constexpr Timing kTimings[] = {{"jitter 10 %", 0.1, 0, 0},
                               {"jitter 50 %", 0.5, 0, 0},
                               {"1 % of ticks lost", 0, 0.01, 0},
                               {"10 % of ticks lost", 0, 0.1, 0},
                               {"30 % of ticks lost", 0, 0.3, 0},
                               {"structural mode at 300 Hz", 0, 0, 300},
                               {"structural mode at 80 Hz", 0, 0, 80}};

enum class Number { kDamping, kFriction, kMass, kMode, kDelay, kCell, kRate };
struct Quantity {
  Number number;
  const char* name;
};
constexpr Quantity kQuantities[] = {
    {Number::kDamping, "damping b"}, {Number::kFriction, "friction c"},
    {Number::kMass, "mass"},         {Number::kMode, "structural mode"},
    {Number::kDelay, "delay"},       {Number::kCell, "cell delta"},
    {Number::kRate, "loop rate"}};

// The least mode that the clause Kc <= m (2 pi f/4)^2 asks for, Hz.
double LeastMode(const DeviceModel& m) {
  return 4 / (2 * std::numbers::pi) * std::sqrt(m.kc_n_per_m / m.mass_kg);
}

// The device as it is, while the law is told what the profile says.
void Multiply(const DeviceModel& m, Number number, double factor, PlantSpec* plant) {
  switch (number) {
    case Number::kDamping:
      plant->damping_n_s_per_m *= factor;
      break;
    case Number::kFriction:
      plant->friction_n *= factor;
      break;
    case Number::kMass:
      plant->mass_kg *= factor;
      break;
    case Number::kMode:
      plant->mode_hz = factor * (m.mode_hz > 0 ? m.mode_hz : LeastMode(m));
      plant->substeps = 16;
      break;
    case Number::kDelay:
      // Of one tick where the profile has none: 1/8 to 1 are none.
      plant->delay_ticks =
          static_cast<int>(std::floor(std::max(1, m.delay_ticks) * factor + 1e-9)) -
          (m.delay_ticks == 0);
      plant->delay_ticks = std::max(0, plant->delay_ticks);
      break;
    case Number::kCell:
      plant->resolution_m *= factor;
      break;
    case Number::kRate:
      plant->tick_s /= factor;
      plant->substeps = std::max(1, static_cast<int>(plant->substeps / factor));
      break;
  }
}

struct Margin {
  const DeviceModel* model;
  const Quantity* quantity;
  double factor;
  Verdict stability = Verdict::kPassive;  // the worst hand's
  bool proved = true;
  std::vector<ExtremeRow> rows;
};

void Measure(Margin* margin, int hands) {
  const DeviceModel& m = *margin->model;
  for (int h = 0; h < hands; ++h) {
    // The two extremes first: quick takes only these.
    const double grip = kGrips_n_per_m[static_cast<size_t>(h == 0 ? 0 : h == 1 ? 3 : h - 1)];
    TrialSpec s = InHand(m, grip);
    Multiply(m, margin->quantity->number, margin->factor, &s.plant);
    const Outcome o = Cut(s);
    ExtremeRow row =
        RowOf(m, std::string(margin->quantity->name) + F(margin->factor, " x %g"), grip, o);
    // Past the clause nothing is proved but that the force is bounded.
    row.quantity = o.proved ? "balance above its floor" : "mean force";
    row.unit = o.proved ? "uJ" : "N";
    row.found = o.proved ? 1e6 * (o.m.energy_min_j - o.m.energy_floor_j) : std::abs(o.m.mean_n);
    row.least = o.proved ? -1e-6 : 0;
    row.most = o.proved ? std::numeric_limits<double>::infinity() : std::sqrt(3.0) * m.peak_force_n;
    margin->proved = margin->proved && o.proved;
    margin->stability = std::max(margin->stability, o.stability);
    margin->rows.push_back(std::move(row));
  }
}

Table MarginTable(const std::vector<Margin>& margins, const std::vector<double>& factors) {
  Table t;
  t.title =
      "How wrong a profile may be: what the device does if one number differs from its profile by "
      "a factor";
  t.head = {"device", "number"};
  for (double f : factors) t.head.push_back(f < 1 ? F(1 / f, "1/%g") : F(f, "x %g"));
  t.note =
      "The worst of the hands. Passive: the theorem's clause holds with the true number. Stable: "
      "it does not, and nothing "
      "swung with these grips. Unstable: the tip swung in a hand; the law's own balance can hold "
      "all the same. Delay: of one tick where the profile has none. Mode: of the least "
      "that the clause asks "
      "for where the profile names none.";
  for (size_t i = 0; i < margins.size(); i += factors.size()) {
    std::vector<std::string> row = {margins[i].model->title, margins[i].quantity->name};
    for (size_t k = 0; k < factors.size(); ++k) {
      const Margin& m = margins[i + k];
      row.push_back(m.stability == Verdict::kStable ? "stable" : VerdictName(m.stability));
    }
    t.rows.push_back(std::move(row));
  }
  return t;
}

}  // namespace

void AddTiming(SuiteContext& c) {
  struct Job {
    const DeviceModel* model;
    const Timing* timing;
    double grip;
  };
  std::vector<Job> jobs;
  for (const DeviceModel& m : c.findings.models)
    for (const Timing& t : kTimings)
      for (double grip : kGrips_n_per_m) jobs.push_back({&m, &t, grip});
  std::vector<ExtremeRow> rows(jobs.size());
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const Job& job = jobs[i];
    TrialSpec s = InHand(*job.model, job.grip);
    const double undisturbed_m = RunTrial(s).deviation_m;
    s.plant.jitter_ratio = job.timing->jitter;
    s.plant.drop_ratio = job.timing->drop;
    s.plant.mode_hz = job.timing->mode_hz;
    s.plant.substeps = 16;
    const Outcome o = Cut(s);
    rows[i] = RowOf(*job.model, job.timing->name, job.grip, o);
    rows[i].quantity = "tip farther off its line than undisturbed";
    rows[i].unit = "cells";
    rows[i].found = (o.m.deviation_m - undisturbed_m) / s.plant.resolution_m;
    rows[i].most = kCells;
  });
  for (ExtremeRow& row : rows) c.findings.extremes.push_back(std::move(row));
}

void AddMargins(SuiteContext& c) {
  const std::vector<double> factors = c.options.quick
                                          ? std::vector<double>{0.125, 0.5, 2, 8}
                                          : std::vector<double>{0.125, 0.25, 0.5, 1, 2, 4, 8};
  std::vector<Margin> margins;
  for (const DeviceModel& m : c.findings.models)
    for (const Quantity& q : kQuantities)
      for (double f : factors) margins.push_back({&m, &q, f, Verdict::kPassive, true, {}});
  std::atomic<size_t> done{0};
  ParallelFor(margins.size(), c.options.threads, [&](size_t i) {
    Measure(&margins[i], c.options.quick ? 2 : 4);
    c.progress("margins", ++done, margins.size());
  });
  c.findings.tables.push_back(MarginTable(margins, factors));
  for (Margin& m : margins)
    for (ExtremeRow& row : m.rows) c.findings.extremes.push_back(std::move(row));
}

Table ExtremeTable(const Findings& f) {
  const auto failed = std::count_if(f.extremes.begin(), f.extremes.end(),
                                    [](const ExtremeRow& r) { return !r.Passed(); });
  Table t;
  t.title = "Extreme cases: " + std::to_string(f.extremes.size() - static_cast<size_t>(failed)) +
            " of " + std::to_string(f.extremes.size()) + " came out as they must";
  t.head = {"case", "device", "hand", "quantity", "expected", "found", "verdict"};
  t.note = "Margins are listed where they failed; --json has every row.";
  for (const ExtremeRow& r : f.extremes) {
    const bool margin = r.name.find(" x ") != std::string::npos;
    if (margin && r.Passed()) continue;
    t.rows.push_back({r.name, r.device, r.hand, r.quantity, r.Expected(), r.Found(),
                      r.Passed() ? "passed" : "failed"});
  }
  return t;
}

std::string ExtremeRow::Expected() const {
  const std::string end = unit.empty() ? "" : " " + unit;
  if (most == least) return F(most, "%.3g") + end;
  if (std::isinf(least)) return F(most, "at most %.3g") + end;
  if (std::isinf(most)) return F(least, "at least %.3g") + end;
  return F(least, "%.3g to ") + F(most, "%.3g") + end;
}

std::string ExtremeRow::Found() const {
  return F(found, "%.3g") + (unit.empty() ? "" : " " + unit);
}

}  // namespace enamel::station::lab
