#include <algorithm>
#include <atomic>
#include <cmath>

#include "station/lab/suites/hand_cases.h"
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
  const char* motion;
  const char* title;
};
constexpr DrawName kDraws[] = {
    {Draw::kUniform, "random", "speeds drawn uniformly"},
    {Draw::kSlow, "random-slow", "speeds drawn logarithmically (slow cuts)"},
    {Draw::kRates, "random-rates", "loop rates of 500 Hz, 2, 4 and 8 kHz"},
    {Draw::kMatrix, "random-matrix", "B a matrix, axes in any direction"}};

// Every case is cut with each of these: prescribed, pushed, and grips of 1 and 0.2 N/mm.
constexpr double kPrescribed = -1;
constexpr double kGrips_n_per_m[] = {kPrescribed, 0, 1000, 200};
constexpr double kMoreRipple_n = 0.05, kMoreError = 0.01;

// The hand of a case on this grip. "hand": separate draws, so that the four grips share all else.
fidelity::HandOn HandOf(const TrialSpec& s, double grip, uint64_t seed) {
  Random r(seed ^ 0x68616e64);
  const double ratio = r.Between(0.1, 0.8), free = r.Between(0, 3);
  fidelity::HandOn hand;
  if (grip == kPrescribed) return hand;
  hand.stiffness_n_per_m = grip;
  hand.mass_kg = s.hand_mass_kg;
  hand.damping_n_s_per_m =
      grip == 0 ? free : 2 * ratio * std::sqrt(grip * (s.hand_mass_kg + s.plant.mass_kg));
  hand.push_n = grip == 0 ? s.b_n_s_per_m * s.direction * s.speed_m_per_s : dvec3(0);
  return hand;
}

struct HeldCase {
  HandRow row;
  std::string repeat;
};

HeldCase RunCase(const DeviceModel& model, uint64_t seed, const DrawName& draw, double grip) {
  const TrialSpec s = RandomCase(model, seed, draw.draw);
  DeviceModel m = model;
  m.rate_hz = 1 / s.plant.tick_s;
  m.friction_n = s.plant.friction_n;
  fidelity::FeltTrial trial;
  trial.b_n_s_per_m = s.b_n_s_per_m;
  trial.hand = HandOf(s, grip, seed);
  const double b = s.b_n_s_per_m.Trace() / 3;
  // Until the plain spring's transient in this hand is down to a tenth.
  const double compliance = 1 / m.kc_n_per_m + (grip > 0 ? 1 / grip : 0);
  const double for_s = std::min(20.0, 2 + 2.3 * b * compliance);
  const std::vector<dvec3> way = ReversalMotion(s.speed_m_per_s, for_s, 0, s.direction).way_m;
  HeldCase out;
  out.row = RowFor(m, b, draw.motion, {}, 0);
  if (grip >= 0) {
    out.row.hand_n_per_mm = grip * 1e-3;
    out.row.hand_kg = s.hand_mass_kg;
  }
  const fidelity::FeltFigures law = Feel(FeltDeviceOf(m), trial, way);
  trial.law = haptics::LawKind::kMaxwell;
  trial.tool = false;
  const fidelity::FeltFigures plain = Feel(FeltDeviceOf(m), trial, way);
  out.row.felt_error = law.command_error();
  out.row.maxwell_error = plain.command_error();
  SetFelt(law, &out.row);
  out.row.ripple_n = law.ripple_n;
  out.row.maxwell_ripple_n = plain.ripple_n;
  out.row.energy_min_j = law.energy_min_j;
  out.repeat = m.name + ", " +
               (grip == kPrescribed
                    ? std::string("prescribed")
                    : F(grip * 1e-3, "%.1f") + " N/mm, " + F(s.hand_mass_kg, "%.2f") + " kg") +
               ", B " + F(b * 1e-3, "%.1f") + ", " + F(s.speed_m_per_s * 1e3, "%.2f") +
               " mm/s, seed " + std::to_string(seed);
  return out;
}

bool RendersAny(const DeviceModel& m) { return kSoftest_n_s_per_m / m.kc_n_per_m <= kSlowest_s; }

void RunDraws(SuiteContext& c, const std::vector<DeviceModel>& models, const DrawName& draw) {
  constexpr size_t kHands = std::size(kGrips_n_per_m);
  auto n = static_cast<size_t>(c.options.quick ? std::min(c.options.cases, 150) : c.options.cases);
  std::vector<HeldCase> held(n * kHands);
  Random draws(c.options.seed);
  std::vector<uint64_t> seeds(n);
  // Drawn before the threads begin, so that the cases do not depend on the threads' order.
  for (uint64_t& seed : seeds) seed = draws.Next();
  std::atomic<size_t> done{0};
  ParallelFor(held.size(), c.options.threads, [&](size_t i) {
    const uint64_t seed = seeds[i / kHands];
    held[i] = RunCase(models[seed % models.size()], seed, draw, kGrips_n_per_m[i % kHands]);
    c.progress("random", ++done, held.size());
  });
  RandomSummary sum;
  sum.title = draw.title;
  for (size_t i = 0; i < n; ++i) {
    // A case holds if it holds in all four hands: a person has one of them, and nobody knows which.
    bool ripples = false, errs = false;
    for (size_t h = 0; h < kHands; ++h) {
      const HeldCase& one = held[i * kHands + h];
      const double ripple = one.row.ripple_n - one.row.maxwell_ripple_n;
      const double error = one.row.felt_error - one.row.maxwell_error;
      sum.ripples_n.push_back(ripple);
      sum.errors.push_back(error);
      if (ripple > kMoreRipple_n || error > kMoreError)
        sum.misses.push_back(one.repeat + ": ripple " + F(ripple, "%+.3f") + " N, felt error " +
                             F(100 * error, "%+.1f") + " points");
      ripples |= ripple > kMoreRipple_n;
      errs |= error > kMoreError;
    }
    ++sum.cases;
    sum.ripple += ripples;
    sum.error += errs;
    sum.held += !ripples && !errs;
  }
  for (HeldCase& one : held) c.findings.hands.push_back(std::move(one.row));
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
