#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "station/lab/suites/suites.h"

namespace enamel::station::lab {

namespace {

// Symmetric with its axes turned at random.
Sym3 RandomMatrix(Random& r, double lo, double hi) {
  dvec3 x = r.Direction(), y = glm::normalize(glm::cross(x, r.Direction()));
  Sym3 b = Sym3::Outer(x, r.Between(lo, hi));
  b += Sym3::Outer(y, r.Between(lo, hi));
  return b += Sym3::Outer(glm::cross(x, y), r.Between(lo, hi));
}

}  // namespace

// Except the device: B 2.5-11.3 N s/mm, speed 0.05-1.0 mm/s, any direction, friction 0-2 Kc delta /
// 2, hand and its mass; B v at most 0.9 of the peak.
TrialSpec RandomCase(const DeviceModel& at_1khz, uint64_t seed, Draw draw) {
  Random r(seed);
  constexpr double kRates_hz[] = {500, 2000, 4000, 8000};
  DeviceModel m = draw == Draw::kRates ? AtRate(at_1khz, kRates_hz[r.Below(4)], false) : at_1khz;
  double v;
  Sym3 b;
  dvec3 direction;
  do {
    b = draw == Draw::kMatrix ? RandomMatrix(r, 2500, 11300)
                              : Sym3::Isotropic(r.Between(2500, 11300));
    v = draw == Draw::kSlow ? r.LogBetween(0.05e-3, 1e-3) : r.Between(0.05e-3, 1e-3);
    direction = r.Direction();
    // Drawn again instead of scaled down, which would change the distribution.
  } while (glm::length(b * direction) * v > 0.9 * m.peak_force_n);
  TrialSpec s = SpecOf(m, haptics::kDefaultLaw, b.Trace() / 3, v);
  s.b_n_s_per_m = b;
  s.direction = direction;
  s.plant.friction_n = r.Uniform() * m.kc_n_per_m * m.resolution_m;
  // Anywhere in a cell: the place of the first count has much influence on a slow cut's beginning.
  s.start_offset_m = dvec3(r.Uniform(), r.Uniform(), r.Uniform()) * m.resolution_m;
  s.hand_mass_kg = r.LogBetween(0.02, 0.5);
  // Half of the cases prescribe velocity; the rest a force or an impedance.
  int hand = r.Below(6);
  s.hand = hand < 3 ? HandKind::kVelocity : hand == 3 ? HandKind::kForce : HandKind::kImpedance;
  s.hand_stiffness_n_per_m = hand == 4 ? 1000 : 200;
  double ratio = r.Between(0.1, 0.8);
  s.hand_damping_n_s_per_m =
      s.hand == HandKind::kForce
          ? r.Between(0, 3)
          : 2 * ratio * std::sqrt(s.hand_stiffness_n_per_m * (s.hand_mass_kg + m.mass_kg));
  return s;
}

namespace {

constexpr double kSoftest_n_s_per_m = 2500;
constexpr double kSlowest_s = 3;  // B/Kc above this is what a profile says it cannot render
constexpr const char* kNone =
    "B/Kc is above 3 s for every B of the draw: the profile says it cannot render this, so nothing "
    "is drawn.";

struct DrawName {
  Draw draw;
  const char* suite;
  const char* title;
};
constexpr DrawName kDraws[] = {
    {Draw::kUniform, "random", "speeds drawn uniformly"},
    {Draw::kSlow, "random-slow", "speeds drawn logarithmically (slow cuts)"},
    {Draw::kRates, "random-rates", "loop rates of 500 Hz, 2, 4 and 8 kHz"},
    {Draw::kMatrix, "random-matrix", "B a matrix, axes in any direction"}};

// Every case is cut with each of these.
struct RandomGrip {
  HandKind kind;
  double stiffness;
};
constexpr RandomGrip kGrips[] = {{HandKind::kVelocity, 0},
                                 {HandKind::kForce, 0},
                                 {HandKind::kImpedance, 1000},
                                 {HandKind::kImpedance, 200}};

void Hold(const RandomGrip& grip, uint64_t seed, const DeviceModel& m, TrialSpec* s) {
  // "hand": separate draws, so that the four grips of a case share everything else.
  Random r(seed ^ 0x68616e64);
  s->hand = grip.kind;
  s->hand_stiffness_n_per_m = grip.stiffness;
  double ratio = r.Between(0.1, 0.8), free = r.Between(0, 3);
  s->hand_damping_n_s_per_m =
      grip.kind == HandKind::kForce
          ? free
          : 2 * ratio * std::sqrt(grip.stiffness * (s->hand_mass_kg + m.mass_kg));
}

// The bounds of common/haptics/README.md, for all four hands of a case.
constexpr double kRise = 1.15, kRelease = 0.55;

void AddCase(const Row* rows, RandomSummary* sum) {
  // A case holds if it holds in all four hands: a person has one of them, and nobody knows which.
  bool error = false, late = false, held_on = false, cycle = false;
  for (size_t h = 0; h < std::size(kGrips); ++h) {
    const Row& r = rows[h];
    bool velocity = r.hand == "velocity";
    double bound = std::max(0.05, 1.15 * r.kc_delta_half_n);
    double rise = velocity ? (r.m.rise90_s < 0 ? 99 : r.m.rise90_s / r.m.rise90_floor_s) : 0;
    double release = velocity ? (r.m.release10_s < 0 ? 99 : r.m.release10_s / r.tau_s) : 0;
    bool misses[] = {r.m.error_max_n > bound, rise > kRise, release > kRelease, r.m.cycle};
    error |= misses[0];
    late |= misses[1];
    held_on |= misses[2];
    cycle |= misses[3];
    sum->errors_n.push_back(r.m.error_max_n / bound);
    if (velocity) {
      sum->rises.push_back(rise / kRise);
      sum->releases.push_back(release / kRelease);
    }
    if (misses[0] || misses[1] || misses[2] || misses[3]) sum->failures.push_back(r);
  }
  ++sum->cases;
  sum->error += error;
  sum->rise += late;
  sum->release += held_on;
  sum->cycle += cycle;
  sum->held += !error && !late && !held_on && !cycle;
}

bool RendersAny(const DeviceModel& m) { return kSoftest_n_s_per_m / m.kc_n_per_m <= kSlowest_s; }

// Devices of the misses: a coarse encoder counts too rarely at 0.05 mm/s to notice a stop.
void AddDeviceTable(Findings& findings, const RandomSummary& sum, const char* suite) {
  Table t{"Random cases by device, " + sum.title,
          "",
          {"device", "cases x four hands", "hold every bound", "delta / (0.05 mm/s), s",
           "B/Kc at 2.5 N s/mm, s"},
          {}};
  for (const DeviceModel& m : findings.models) {
    auto Of = [&](const std::vector<Row>& rows) {
      return std::count_if(rows.begin(), rows.end(),
                           [&](const Row& r) { return r.profile == m.name && r.suite == suite; });
    };
    auto cases = Of(findings.rows), missed = Of(sum.failures);
    char gap[32], tau[32];
    std::snprintf(gap, sizeof gap, "%.2f", m.resolution_m / 0.05e-3);
    std::snprintf(tau, sizeof tau, "%.2f", 2500 / m.kc_n_per_m);
    t.rows.push_back({m.title, std::to_string(cases),
                      RendersAny(m) ? std::to_string(cases - missed) : "none drawn: B/Kc > 3 s",
                      gap, tau});
  }
  findings.tables.push_back(std::move(t));
}

void RunDraws(SuiteContext& c, const std::vector<DeviceModel>& models, const DrawName& draw) {
  auto n = static_cast<size_t>(c.options.quick ? std::min(c.options.cases, 150) : c.options.cases);
  std::vector<Row> rows(n * std::size(kGrips));
  Random draws(c.options.seed);
  std::vector<uint64_t> seeds(n);
  // Drawn before the threads begin, so that the cases do not depend on the threads' order.
  for (uint64_t& seed : seeds) seed = draws.Next();
  std::atomic<size_t> done{0};
  ParallelFor(rows.size(), c.options.threads, [&](size_t i) {
    const uint64_t seed = seeds[i / std::size(kGrips)];
    const DeviceModel& m = models[seed % models.size()];
    TrialSpec spec = RandomCase(m, seed, draw.draw);
    Hold(kGrips[i % std::size(kGrips)], seed, m, &spec);
    rows[i] = RunRow(m, spec);
    rows[i].suite = draw.suite;
    rows[i].title = "seed " + std::to_string(seed);
    c.progress("random", ++done, rows.size());
  });
  RandomSummary sum;
  sum.title = draw.title;
  for (size_t i = 0; i < n; ++i) AddCase(&rows[i * std::size(kGrips)], &sum);
  for (Row& r : rows) c.findings.rows.push_back(std::move(r));
  AddDeviceTable(c.findings, sum, draw.suite);
  c.findings.random.push_back(std::move(sum));
}

}  // namespace

void RunRandomSuite(SuiteContext& c) {
  std::vector<DeviceModel> models;
  for (const DeviceModel& m : c.findings.models) {
    if (RendersAny(m)) models.push_back(m);
  }
  if (models.empty()) {
    c.findings.tables.push_back(
        {"Random cases: none", kNone, {"device"}, {{c.findings.models[0].title}}});
    return;
  }
  for (const DrawName& draw : kDraws) RunDraws(c, models, draw);
}

}  // namespace enamel::station::lab
