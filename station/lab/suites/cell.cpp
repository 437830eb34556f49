#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "common/haptics/criteria.h"
#include "common/haptics/uniform_material.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

const char* HandName(const TrialSpec& s) {
  if (s.hand == HandKind::kVelocity) return "velocity";
  if (s.hand == HandKind::kForce) return "force";
  // Grips are 1000 and 200 N/m; a drawn one is named after the nearer.
  return s.hand_stiffness_n_per_m > 600 ? "impedance-1" : "impedance-0.2";
}

Verdict VerdictOf(const TrialSpec& spec, const Measurement& m) {
  if (m.unstable) return Verdict::kUnstable;
  if (Proved(spec) && !m.violation) return Verdict::kPassive;
  // A law that pulls its hand along releases energy without a swing.
  return m.cycle || m.violation ? Verdict::kBounded : Verdict::kStable;
}

}  // namespace

std::string F(double v, const char* format) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, format, v)), '\0');
  std::snprintf(text.data(), text.size() + 1, format, v);
  return text;
}

const char* VerdictName(Verdict v) {
  switch (v) {
    case Verdict::kPassive:
      return "passive";
    case Verdict::kStable:
      return "stable with these grips";
    case Verdict::kBounded:
      return "bounded";
    case Verdict::kUnstable:
      return "unstable";
  }
  return "unstable";
}

void ParallelFor(size_t n, int threads, const std::function<void(size_t)>& job) {
  std::atomic<size_t> next{0};
  auto work = [&] {
    // One counter instead of equal parts: jobs differ much in cost.
    for (size_t i = next++; i < n; i = next++) job(i);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
}

bool ProvedLaw(LawKind law) { return law == LawKind::kMaxwell || law == LawKind::kLeadMaxwell; }

bool Proved(const TrialSpec& s) {
  if (!ProvedLaw(s.law.kind)) return false;
  if (s.plant.jitter_ratio > 0 || s.plant.drop_ratio > 0 || s.plant.mode_hz > 0) return false;
  const Lattice& lattice = s.plant.lattice;
  bool along_axes = lattice.joints == glm::dmat3(1) && lattice.driver_cell_m == 0;
  if (!along_axes || lattice.noise_counts != 0) return false;  // the law is not told of them here
  // A profile's Kc may be the very limit, rounded to whole mN/mm and back.
  double slack = 1 + 1e-9;
  return s.law.kc_n_per_m <= slack * haptics::CouplingStiffness(s.plant.damping_n_s_per_m,
                                                                s.plant.tick_s,
                                                                s.plant.delay_ticks) &&
         haptics::CouplingFriction(s.law.kc_n_per_m, s.plant.resolution_m) <=
             slack * s.plant.friction_n;
}

double ErrorGoal(const DeviceModel& m, double floor_n, double factor) {
  return std::max(floor_n, factor * m.kc_n_per_m * m.resolution_m / 2);
}

Row RunRow(const DeviceModel& model, const TrialSpec& spec) {
  Row row;
  row.profile = model.name;
  row.law = haptics::FindLaw(spec.law.kind)->name;
  const haptics::EstimatorEntry* estimator = haptics::FindEstimator(spec.law.estimator.kind);
  row.estimator = estimator ? estimator->name : "own";
  row.hand = HandName(spec);
  row.rate_hz = 1 / spec.law.tick_s;
  double b = spec.b_n_s_per_m.Trace() / 3;
  row.b_n_s_per_mm = b * 1e-3;
  row.speed_mm_s = spec.speed_m_per_s * 1e3;
  row.kc_n_per_mm = spec.law.kc_n_per_m * 1e-3;
  row.tau_s = b / spec.law.kc_n_per_m;
  row.kc_delta_half_n = spec.law.kc_n_per_m * spec.plant.resolution_m / 2;
  row.m = RunTrial(spec);
  row.verdict = VerdictOf(spec, row.m);
  row.is_default = spec.law.kind == haptics::kDefaultLaw;
  return row;
}

double NanosecondsPerTick(const TrialSpec& spec) {
  haptics::CouplingParams p;
  p.law = spec.law;
  p.peak_force_n = spec.peak_force_n;
  haptics::Coupling coupling(p);
  haptics::UniformMaterial material(spec.b_n_s_per_m);
  dvec3 direction = glm::normalize(dvec3(1, 2, 3));
  coupling.Reset(dvec3(0));
  constexpr int kTicks = 4000, kRepeats = 5;
  double best = 1e9;
  int64_t tick = 0;
  std::vector<dvec3> tips(kTicks);
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (dvec3& tip : tips) {
      tip = CellMiddle(
          direction * (spec.speed_m_per_s * spec.law.tick_s * static_cast<double>(tick++)),
          spec.plant.resolution_m);
    }
    auto from = std::chrono::steady_clock::now();
    for (const dvec3& tip : tips) coupling.Tick(tip, 1, material);
    std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - from;
    // The minimum of several: every disturbance makes a measurement longer.
    best = std::min(best, took.count() / kTicks);
  }
  return best;
}

}  // namespace enamel::station::lab
