#include <atomic>
#include <cmath>

#include "common/scene/delay.h"
#include "common/scene/rate.h"
#include "station/lab/laws/motions.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr double kGrip_n_per_m = 1000, kSpeed_m_per_s = 0.2e-3;
constexpr uint64_t kMotions = 5;

struct Job {
  DeviceModel model;
  std::string limit;
};

// The unchanged profile first, then each rate. Delays count in ticks of the rate.
std::vector<Job> JobsFor(const DeviceModel& m) {
  std::vector<Job> jobs{{m, "as the profile says"}};
  for (int64_t delay : {0, 1}) {
    for (int64_t rate : {1000, 2000, 4000, 8000}) {
      scene::DeviceProfile profile = m.profile;
      // The profile's own delay belongs to its own rate; here 0 and 1 are compared at every rate.
      profile.bus_delay_ticks.value = 0;
      Result<scene::DeviceProfile> at = scene::AtRate(profile, rate);
      // A rate that is impossible for the profile has no row.
      if (!at.ok()) continue;
      at->bus_delay_ticks.value = delay;
      const scene::LargestCoupling largest = scene::LargestCouplingAt(*at, rate, delay);
      at->coupling_mn_per_mm.value = largest.coupling_mn_per_mm;
      Result<DeviceModel> model = ModelOf(*at);
      if (model.ok()) jobs.push_back({*model, scene::CouplingLimitName(largest.limit)});
    }
  }
  return jobs;
}

}  // namespace

void RunRatesSuite(SuiteContext& c) {
  Table t;
  t.title = "Loop rates: the largest coupling each device may have, and what a hand gets of it";
  t.note =
      "Kc = min(2 b f/(d + 1)^2, 2 c/delta, K); limit: which of them binds. B 6.5 N s/mm, five "
      "generated hands of 1 N/mm that wander at 0.2 mm/s for 12 s each. Felt error against an "
      "ideal "
      "damper in the same hand: default law, and plain Maxwell. A delay of one tick is shorter at "
      "a "
      "higher rate.";
  t.head = {"device", "rate Hz",      "delay ticks",  "Kc N/mm",
            "limit",  "Kc delta/2 N", "felt error %", "plain Maxwell %"};
  for (const DeviceModel& m : c.findings.models) {
    const std::vector<Job> jobs = JobsFor(m);
    std::vector<RateRow> rows(jobs.size());
    std::atomic<size_t> done{0};
    ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
      const DeviceModel& model = jobs[i].model;
      fidelity::FeltTrial trial;
      trial.hand.stiffness_n_per_m = kGrip_n_per_m;
      trial.delay_ticks = model.delay_ticks;
      auto Error = [&](haptics::LawKind law) {
        trial.law = law;
        double error2 = 0, ideal2 = 0;
        for (uint64_t seed = 1; seed <= kMotions; ++seed) {
          const fidelity::FeltFigures f =
              Feel(FeltDeviceOf(model), trial, WanderingMotion(kSpeed_m_per_s, 12, seed).way_m);
          error2 += f.error_rms_n * f.error_rms_n;
          ideal2 += f.ideal_rms_n * f.ideal_rms_n;
        }
        return std::sqrt(error2 / ideal2);
      };
      rows[i] = {m.name,
                 jobs[i].limit,
                 model.rate_hz,
                 model.kc_n_per_m * 1e-3,
                 model.delay_ticks,
                 model.kc_n_per_m * model.resolution_m / 2,
                 Error(haptics::kDefaultLaw),
                 Error(haptics::LawKind::kMaxwell)};
      c.progress("rates", ++done, jobs.size());
    });
    for (const RateRow& r : rows) {
      t.rows.push_back({m.title, F(r.rate_hz, "%.0f"), F(r.delay_ticks, "%.0f"),
                        F(r.kc_n_per_mm, "%.2f"), r.limit, F(r.kc_delta_half_n),
                        F(100 * r.felt_error, "%.0f"), F(100 * r.maxwell_error, "%.0f")});
      c.findings.rates.push_back(r);
    }
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace enamel::station::lab
