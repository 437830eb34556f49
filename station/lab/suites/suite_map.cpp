#include <atomic>
#include <cmath>

#include "common/fidelity/feel.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/rate.h"
#include "station/lab/laws/motions.h"
#include "station/lab/suites/suites.h"

// Up to which grip a hand feels F = B v, per device, loop rate and tissue (common/fidelity/feel.h).
namespace enamel::station::lab {
namespace {

using haptics::LawKind;

constexpr double kSpeed_m_per_s = 0.2e-3, kDuration_s = 12;

struct Condition {
  Unit unit;
  std::string limit;
};

// The device as shipped, not calibrated and calibrated; then, calibrated, the rates with the largest Kc there,
// without delay and with a tick.
std::vector<Condition> ConditionsOf(const DeviceModel& m, bool quick) {
  std::vector<Condition> out;
  for (const bool calibrated : {false, true}) {
    Result<Unit> unit = UnitOf(m.profile, calibrated);
    if (unit.ok()) out.push_back({std::move(*unit), ""});
  }
  for (int64_t delay : {0, 1}) {
    for (int64_t rate : {1000, 4000, 8000}) {
      if (quick && (delay != 0 || rate != 8000)) continue;
      scene::DeviceProfile profile = m.profile;
      // The profile's own delay belongs to its own rate; here 0 and 1 are compared at every rate.
      profile.bus_delay_ticks.value = 0;
      Result<scene::DeviceProfile> at = scene::AtRate(profile, rate);
      // A rate that is impossible for the profile has no curve.
      if (!at.ok()) continue;
      at->bus_delay_ticks.value = delay;
      const scene::LargestCoupling largest = scene::LargestCouplingAt(*at, rate, delay);
      at->coupling_mn_per_mm.value = largest.coupling_mn_per_mm;
      Result<Unit> unit = UnitOf(*at, true);
      if (unit.ok()) out.push_back({std::move(*unit), scene::CouplingLimitName(largest.limit)});
    }
  }
  return out;
}

std::vector<scene::TissueSpec> Tissues(bool quick) {
  using cutting::Tissue;
  if (quick) return scene::DefaultTissues({Tissue::kEnamel, Tissue::kCaries});
  return scene::DefaultTissues({Tissue::kEnamel, Tissue::kDentin, Tissue::kCaries, Tissue::kPulp});
}

FeelCurve CurveOf(const Condition& condition, const scene::TissueSpec& tissue, LawKind law) {
  const DeviceModel& m = condition.unit.model;
  FeelCurve c;
  c.device = m.name;
  c.title = m.title;
  c.tissue = cutting::TissueName(tissue.tissue);
  c.law = haptics::FindLaw(law)->name;
  c.b_n_s_per_mm = tissue.damping_mn_s_per_mm * 1e-3;
  c.rate_hz = m.rate_hz;
  c.kc_n_per_mm = m.kc_n_per_m * 1e-3;
  c.friction_n = m.friction_n;
  c.delay_ticks = m.delay_ticks;
  c.calibrated = condition.unit.calibrated;
  c.limit = condition.limit;
  const double b = tissue.damping_mn_s_per_mm;  // mN s/mm = N s/m
  const double spring =
      law == LawKind::kLeadMaxwell ? haptics::LeadStiffness(m.kc_n_per_m, b) : m.kc_n_per_m;
  for (double grip : fidelity::kGrips_n_per_m)
    c.closed_form.push_back(fidelity::ClosedFormError(grip, spring, b, fidelity::kHand_rad_per_s));
  c.error.resize(std::size(fidelity::kGrips_n_per_m));
  return c;
}

// "7 %: 1.2, 15 %: 3.4": three grips of a column, N/mm.
std::string Grips(const std::vector<double>& errors) {
  std::string text;
  for (double share : fidelity::kShares) {
    const double grip = fidelity::StiffestGrip(fidelity::kGrips_n_per_m, errors, share) * 1e-3;
    text += (text.empty() ? "" : " / ") + (grip > 0 ? F(grip, "%.1f") : std::string("-"));
  }
  return text;
}

void AddTable(SuiteContext& c, size_t from) {
  Table t;
  t.title =
      "What a hand can feel: stiffest grip, N/mm, in which cutting feels right within 7 / 15 / 19 "
      "%";
  t.note =
      "A hand's grip is 0.3 (loose) to 2 N/mm (firm). Felt: the force in the hand, friction, "
      "damping "
      "and inertia in, against that on an ideal tool, which is a damper and weighs nothing. Closed "
      "form: |H/H_ideal - 1| of a spring "
      "K = Kc "
      "(plain Maxwell) or n Kc (lead Maxwell) at 1.6 rad/s, about kh/(kh + K). -: not even at 0.3; "
      "20.0: at "
      "least. Not calibrated: with the delay that a station assumes of an attached device, and Kc "
      "lowered to it. Kc: the profile's (limit empty), else the largest at that rate and delay. "
      "The "
      "device's friction is left out of what the motors are asked for, as in an attempt. Generated "
      "hands that work a surface at 0.2 mm/s.";
  t.head = {"device",  "calibrated", "tissue", "B N s/mm", "rate Hz",    "delay",
            "Kc N/mm", "limit",      "law",    "felt",     "closed form"};
  for (size_t i = from; i < c.findings.feel.size(); ++i) {
    const FeelCurve& r = c.findings.feel[i];
    t.rows.push_back({r.title, r.calibrated ? "yes" : "no", r.tissue, F(r.b_n_s_per_mm, "%.1f"),
                      F(r.rate_hz, "%.0f"), std::to_string(r.delay_ticks), F(r.kc_n_per_mm, "%.2f"),
                      r.limit, r.law, Grips(r.error), Grips(r.closed_form)});
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace

void RunMapSuite(SuiteContext& c) {
  std::vector<std::vector<dvec3>> ways;
  for (uint64_t seed = 1; seed <= (c.options.quick ? 1 : 2); ++seed)
    ways.push_back(WanderingMotion(kSpeed_m_per_s, kDuration_s, seed).way_m);
  struct Job {
    fidelity::FeltDevice device;
    fidelity::FeltTrial trial;
    size_t curve, grip;
  };
  std::vector<Job> jobs;
  const size_t from = c.findings.feel.size();
  for (const DeviceModel& m : c.findings.models) {
    for (const Condition& condition : ConditionsOf(m, c.options.quick)) {
      for (const scene::TissueSpec& tissue : Tissues(c.options.quick)) {
        for (LawKind law : {haptics::kDefaultLaw, LawKind::kMaxwell}) {
          fidelity::FeltTrial trial;
          trial.law = law;
          trial.b_n_s_per_m = Sym3::Isotropic(tissue.damping_mn_s_per_mm);
          trial.delay_ticks = condition.unit.model.delay_ticks;
          trial.friction = condition.unit.told;
          for (size_t grip = 0; grip < std::size(fidelity::kGrips_n_per_m); ++grip)
            jobs.push_back(
                {FeltDeviceOf(condition.unit.model), trial, c.findings.feel.size(), grip});
          c.findings.feel.push_back(CurveOf(condition, tissue, law));
        }
      }
    }
  }
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const Job& job = jobs[i];
    c.findings.feel[job.curve].error[job.grip] =
        fidelity::FeltIn(job.device, job.trial, fidelity::kGrips_n_per_m[job.grip], ways);
    c.progress("map: grips", ++done, jobs.size());
  });
  AddTable(c, from);
}

}  // namespace enamel::station::lab
